// Memory in large pages where the system has them: tens of megabytes come many times sooner, and reading here and
// there in them misses the page table less.
#pragma once

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <cstddef>
#include <cstring>
#include <vector>

#include "geometry/base/large_pages.h"

namespace kerf::internal {

/// reserve(), asking for large pages before the first one is touched. Whether the system grants it changes no result.
template <class T>
void reserveLarge(std::vector<T>& to, std::size_t count) {
  to.reserve(count);
  adviseLargePages(static_cast<void*>(to.data()), to.capacity() * sizeof(T));
}

/// Gives the system what is free between blocks in use. The C library keeps it, and a large block that is taken next
/// comes on top of it. @cost milliseconds.
inline void returnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

/// Makes sure of memory for `least` elements. Where there is less it reserves `wanted` and writes to every page:
/// filling it later does not wait for memory. Drops what is in it then. T can be copied byte by byte.
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
