// Denormal numbers count as zero.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace kerf {

/// While it lives, this thread reads and writes denormal numbers as zero. They cost a hundred times as much as others,
/// at unforeseeable moments. Restores the caller's mode. On processors other than x86 and arm64 it does nothing.
/// @rt safe
class FlushDenormals {
 public:
  FlushDenormals() noexcept : before_(mode()) { setMode(before_ | kFlush); }
  ~FlushDenormals() { setMode(before_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
#if defined(__SSE2__)
  using Mode = unsigned;
  static constexpr Mode kFlush = 0x8040;  // MXCSR: FTZ for results, DAZ for operands
  static Mode mode() noexcept { return _mm_getcsr(); }
  static void setMode(Mode mode) noexcept { _mm_setcsr(mode); }
#elif defined(__aarch64__)
  using Mode = std::uint64_t;
  static constexpr Mode kFlush = 1u << 24;  // FPCR.FZ: results and operands
  static Mode mode() noexcept {
    Mode mode;
    asm volatile("mrs %0, fpcr" : "=r"(mode)::"memory");
    return mode;
  }
  static void setMode(Mode mode) noexcept { asm volatile("msr fpcr, %0" ::"r"(mode) : "memory"); }
#else
  using Mode = unsigned;
  static constexpr Mode kFlush = 0;
  static Mode mode() noexcept { return 0; }
  static void setMode(Mode) noexcept {}
#endif

  Mode before_;
};

}  // namespace kerf
