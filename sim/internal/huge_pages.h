// Memory in large pages where the system has them: tens of megabytes come many times sooner, and looking things up in
// them misses the page table less.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
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

/// The same, with every page written to: whoever fills it later does not wait for memory. Drops what is in it.
template <class T>
void reserveTouched(std::vector<T>& to, std::size_t count) {
  if (to.capacity() >= count) return;
  to.clear();
  reserveLarge(to, count);
  to.resize(count), to.clear();
}

}  // namespace kerf::internal
