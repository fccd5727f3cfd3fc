// Parts of vibrations: a sine, white noise and a band of it. The same bits on every system: plain products and sums of
// doubles, phases in whole numbers. All @rt safe, some ns a call.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace kerf::internal {

/// 0 below `from`, 1 above `to`, smooth between.
inline double fade(double x, double from, double to) noexcept {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// `x` within 0 to `most`; 0 if it is not finite.
inline double usable(double x, double most) noexcept { return std::isfinite(x) ? std::clamp(x, 0.0, most) : 0; }

/// Sine of a phase of 2^32 a turn. A polynomial over a quarter turn either way, within 4e-6: the library's sine differs
/// between systems in the last bit.
inline double sine(std::uint32_t phase) noexcept {
  auto quarter = static_cast<std::int32_t>(phase);
  // Second and third quarter turn: mirrored.
  if (quarter > 0x40000000 || quarter < -0x40000000) quarter = static_cast<std::int32_t>(0x80000000u - phase);
  const double x = quarter * (2 * std::numbers::pi / 4294967296.0), x2 = x * x;
  return x * (1 + x2 * (-1.0 / 6 + x2 * (1.0 / 120 + x2 * (-1.0 / 5040 + x2 * (1.0 / 362880)))));
}

/// Phase step of one sample, at `rate` samples a second.
inline std::uint32_t phaseStep(double frequency, double rate) noexcept {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(frequency / rate * 4294967296.0));
}

/// White noise, evenly in [-1, 1): splitmix64 (Steele, Lea & Flood 2014), its upper half as a number.
class WhiteNoise {
 public:
  explicit WhiteNoise(std::uint64_t seed) noexcept : state_(seed) {}
  double next() noexcept {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t bits = state_;
    bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
    bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
    bits ^= bits >> 31;
    return static_cast<std::int32_t>(bits >> 32) / 2147483648.0;
  }

 private:
  std::uint64_t state_;
};

/// A state-variable filter in trapezoidal form. Nothing passes at zero frequency.
class BandPass {
 public:
  /// @param g  tan(pi middle / rate).   @param damping  1 / Q.   @return gain 1 / damping at the middle.
  double next(double in, double g, double damping) noexcept {
    const double high = (in - (damping + g) * band_ - low_) / (1 + damping * g + g * g);
    const double band = g * high + band_, low = g * band + low_;
    band_ = g * high + band;
    low_ = g * band + low;
    return band;
  }

 private:
  double low_ = 0, band_ = 0;
};

}  // namespace kerf::internal
