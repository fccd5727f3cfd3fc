// Memory in large pages where the system has them: tens of megabytes come many times sooner, and reading here and
// there in them misses the page table less.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace kerf::internal {

/// reserve(), asking for large pages before the first one is touched. Whether the system grants it changes no result.
template <class T>
void reserveLarge(std::vector<T>& to, std::size_t count) {
  to.reserve(count);
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t kPage = std::uintptr_t{1} << 21;
  const auto begin = (reinterpret_cast<std::uintptr_t>(to.data()) + kPage - 1) & ~(kPage - 1);
  const auto end = reinterpret_cast<std::uintptr_t>(to.data() + to.capacity()) & ~(kPage - 1);
  if (begin < end) static_cast<void>(madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE));
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
