// Memory in large pages where the system has them: hundreds of megabytes come with 512 times fewer page faults.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>

namespace kerf::internal {

/// Asks for large pages for memory that was reserved and not touched yet. Whether the system grants it changes no
/// result. @param bytes  from `begin` on; what lies in it may belong to nobody else.
inline void adviseLargePages(void* begin, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t kPage = std::uintptr_t{1} << 21;
  const auto at = reinterpret_cast<std::uintptr_t>(begin);
  const std::uintptr_t from = (at + kPage - 1) & ~(kPage - 1), to = (at + bytes) & ~(kPage - 1);
  if (from < to) static_cast<void>(madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE));
#else
  static_cast<void>(begin);
  static_cast<void>(bytes);
#endif
}

}  // namespace kerf::internal
