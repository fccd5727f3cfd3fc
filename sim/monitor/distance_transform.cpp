#include "sim/monitor/distance_transform.h"

#include <algorithm>
#include <limits>

namespace kerf::internal {

// The envelope from left to right. Squares are whole numbers below 2^24, so distances come out exact.
void DistanceTransform::line(const float* in, std::ptrdiff_t in_stride, int n, float* out, std::ptrdiff_t out_stride,
                             int low, int high) {
  constexpr float kLeftmost = -std::numeric_limits<float>::infinity();
  std::size_t count = 0;
  for (int q = 0; q < n; ++q) {
    const float f = in[q * in_stride];
    if (f >= kNone) continue;
    float from = kLeftmost;  // where this parabola falls below the one before
    while (count > 0) {
      const int p = at_[count - 1];
      from = ((f - value_[count - 1]) + static_cast<float>(q * q - p * p)) / static_cast<float>(2 * (q - p));
      if (from > from_[count - 1]) break;
      --count;
      from = kLeftmost;
    }
    at_[count] = q;
    value_[count] = f;
    from_[count] = from;
    ++count;
  }

  std::size_t k = 0;
  for (int q = low; q < high; ++q) {
    while (k + 1 < count && from_[k + 1] < static_cast<float>(q)) ++k;
    const auto d = static_cast<float>(count > 0 ? q - at_[k] : 0);
    out[(q - low) * out_stride] = count > 0 ? value_[k] + d * d : kNone;
  }
}

std::span<const float> DistanceTransform::run(std::span<const std::uint8_t> seeds, const Vec3i& size, const Vec3i& low,
                                              const Vec3i& high) {
  const Vec3i part = high - low;
  const auto longest = static_cast<std::size_t>(size.maxCoeff());
  value_.resize(longest);
  from_.resize(longest);
  at_.resize(longest);
  row_.resize(longest);
  const std::ptrdiff_t slab = static_cast<std::ptrdiff_t>(size[1]) * part[2];  // of along_z_, per x
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(part[1]) * part[2];
  along_z_.resize(static_cast<std::size_t>(slab));
  along_y_.resize(static_cast<std::size_t>(size[0] * plane));
  out_.resize(static_cast<std::size_t>(part[0] * plane));

  // Along z and then y, one x after the other; last along x.
  for (int i = 0; i < size[0]; ++i) {
    float* const y_plane = along_y_.data() + i * plane;
    bool has_seeds = false;
    for (int j = 0; j < size[1]; ++j) {
      const std::uint8_t* const row = seeds.data() + (static_cast<std::ptrdiff_t>(i) * size[1] + j) * size[2];
      float* const z_row = along_z_.data() + static_cast<std::ptrdiff_t>(j) * part[2];
      if (std::find(row, row + size[2], std::uint8_t{1}) == row + size[2]) {
        std::fill_n(z_row, part[2], kNone);
        continue;
      }
      has_seeds = true;
      std::transform(row, row + size[2], row_.begin(), [](std::uint8_t s) { return s ? 0.0f : kNone; });
      line(row_.data(), 1, size[2], z_row, 1, low[2], high[2]);
    }

    if (has_seeds)
      for (int k = 0; k < part[2]; ++k)
        line(along_z_.data() + k, part[2], size[1], y_plane + k, part[2], low[1], high[1]);
    else
      std::fill_n(y_plane, plane, kNone);
  }

  for (std::ptrdiff_t n = 0; n < plane; ++n)
    line(along_y_.data() + n, plane, size[0], out_.data() + n, plane, low[0], high[0]);
  return out_;
}

}  // namespace kerf::internal
