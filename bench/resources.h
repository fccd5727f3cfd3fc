// What a scene measures beside the clock.
#pragma once

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>

namespace kerf::cli {

/// Time of all processors that this program has used, ms.
inline double processorTime() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

inline void clearPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }
/// Most memory this program has had since clearPeak(), GB; 0 where the system does not tell.
inline double peakGigabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::strtod(line.c_str() + 6, nullptr) * 1024 / 1e9;
  return 0;
}

}  // namespace kerf::cli
