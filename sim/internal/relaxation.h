// exp(-x) and 1 - exp(-x) for rates times time steps: plain arithmetic, so that they vectorise and give the same bits
// with any C library.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace kerf {

/// exp(-x), x >= 0; relative error below 2e-7, 0 beyond x = 87.
inline float decay(float x) noexcept {
  constexpr float kLog2e = 1.44269504f, kLn2High = 0.693145752f, kLn2Low = 1.42860677e-6f;
  const float bounded = std::min(x, 87.0f);
  const int n = static_cast<int>(bounded * kLog2e + 0.5f);
  const float turns = static_cast<float>(n);
  const float r = (bounded - turns * kLn2High) - turns * kLn2Low;  // |r| <= ln(2) / 2
  float series = 1;
  for (const float part : {1.0f / 6, 1.0f / 5, 1.0f / 4, 1.0f / 3, 1.0f / 2, 1.0f}) series = 1 - r * part * series;
  const float power = std::bit_cast<float>(static_cast<std::int32_t>(127 - n) << 23);
  return x < 87.0f ? series * power : 0.0f;
}

/// 1 - exp(-x), x >= 0, without cancellation where x is small.
inline float relaxed(float x) noexcept {
  float small = 1;
  for (const float part : {1.0f / 5, 1.0f / 4, 1.0f / 3, 1.0f / 2}) small = 1 - x * part * small;
  small *= x;
  const float rest = 1 - decay(x);
  return x < 0.125f ? small : rest;
}

/// (1 - exp(-x)) / x: the mean of exp(-s x) over 0 <= s <= 1.
inline float meanDecay(float x) noexcept { return x < 1e-6f ? 1.0f : relaxed(x) / x; }

}  // namespace kerf
