// Memory in large pages where the system has them. Tens of megabytes arrive many times sooner, and scattered reads miss
// the page table less.
#pragma once

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <cstddef>
#include <cstring>
#include <vector>

#include "geometry/base/large_pages.h"

namespace kerf::internal {

/// reserve(), with a request for large pages before the first access. The system's answer changes no result.
template <class T>
void reserveLarge(std::vector<T>& to, std::size_t count) {
  to.reserve(count);
  adviseLargePages(static_cast<void*>(to.data()), to.capacity() * sizeof(T));
}

/// Returns free memory between used blocks to the system. Otherwise the C library keeps it, and the next large block
/// comes on top. @cost milliseconds.
inline void returnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

/// Ensures memory for `least` elements. If there is less, it reserves `wanted` elements, writes to every page, and
/// drops the contents: filling it later does not wait for memory. T can be copied byte by byte.
template <class T>
void reserveTouched(std::vector<T>& to, std::size_t least, std::size_t wanted) {
  if (to.capacity() >= least) return;
  to.clear();
  reserveLarge(to, wanted);
  to.resize(wanted);
  std::memset(static_cast<void*>(to.data()), 0, wanted * sizeof(T));  // Eigen's vectors are made without writing
  to.clear();
}

}  // namespace kerf::internal
