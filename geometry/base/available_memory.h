// How much memory the machine can still give.
#pragma once

#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

namespace kerf::internal {

/// Bytes that can be had without swapping, as Linux estimates them; the largest number where it does not tell.
inline std::uint64_t availableMemory() {
  std::ifstream info("/proc/meminfo");
  for (std::string key; info >> key;) {
    std::uint64_t kilobytes = 0;
    if (key == "MemAvailable:" && info >> kilobytes) return kilobytes * 1024;
  }
  return std::numeric_limits<std::uint64_t>::max();
}

}  // namespace kerf::internal
