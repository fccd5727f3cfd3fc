// Available memory of the machine.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

namespace kerf::internal {

/// Bytes available without swapping, as estimated by Linux, and within the limit of this process (ulimit -v); the
/// largest number if unknown.
inline std::uint64_t availableMemory() {
  std::uint64_t limit = std::numeric_limits<std::uint64_t>::max(), pages = 0;
  if (rlimit most{}; ::getrlimit(RLIMIT_AS, &most) == 0 && most.rlim_cur != RLIM_INFINITY) {
    std::ifstream("/proc/self/statm") >> pages;
    limit = most.rlim_cur - std::min<std::uint64_t>(most.rlim_cur, pages * static_cast<std::uint64_t>(::getpagesize()));
  }
  std::ifstream info("/proc/meminfo");
  for (std::string key; info >> key;) {
    std::uint64_t kilobytes = 0;
    if (key == "MemAvailable:" && info >> kilobytes) return std::min(limit, kilobytes * 1024);
  }
  return limit;
}

}  // namespace kerf::internal
