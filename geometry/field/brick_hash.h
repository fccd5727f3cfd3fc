// The terms of BrickField::stateHash(), to update it brick by brick.
#pragma once

#include <bit>

#include "geometry/field/brick_field.h"

namespace kerf {

namespace internal {
constexpr std::uint64_t mixHash(std::uint64_t h, std::uint64_t v) {
  h = (h ^ v) * 0x9e3779b97f4a7c15ull;
  return h ^ (h >> 29);
}
}  // namespace internal

/// The hash of a field without bricks; every brick adds its brickHashes() to it, in any order.
inline std::uint64_t hashOfNoBricks(double voxel) noexcept {
  return internal::mixHash(0x6b657266ull, std::bit_cast<std::uint64_t>(voxel));
}

/// Terms of bricks with these keys (coordKey) and values. Four in parallel take as long as one: a hash waits for its
/// last value, not for the processor.  @rt safe.
template <int N>
std::array<std::uint64_t, N> brickHashes(const std::array<std::uint64_t, N>& keys,
                                         const std::array<const float*, N>& values) noexcept {
  std::array<std::uint64_t, N> h;
  for (std::size_t n = 0; n < N; ++n) h[n] = internal::mixHash(0x627269636bull, keys[n]);
  for (int i = 0; i < kBrickNodes; ++i)
    for (std::size_t n = 0; n < N; ++n) h[n] = internal::mixHash(h[n], std::bit_cast<std::uint32_t>(values[n][i]));
  return h;
}

}  // namespace kerf
