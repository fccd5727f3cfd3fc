// Measurements of a scene besides wall time.
#pragma once

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>

namespace kerf::cli {

/// CPU time of this program over all processors, ms.
inline double processorTime() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

inline void clearPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }
/// Peak memory of this program since clearPeak(), GB; 0 if the system does not report it.
inline double peakGigabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::strtod(line.c_str() + 6, nullptr) * 1024 / 1e9;
  return 0;
}

}  // namespace kerf::cli
