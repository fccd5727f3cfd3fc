// Exact Euclidean distance transform of a dense box of nodes, one axis after the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/types.h"

namespace kerf::internal {

/// Squared distances, in voxels, to the nearest seed: lower envelopes of parabolas, after Felzenszwalb & Huttenlocher,
/// Theory Comput 2012;8:415. Keeps its memory between calls; one per thread.
class DistanceTransform {
 public:
  static constexpr float kNone = 1e20f;  ///< no seed in the box
  /// @param seeds  one number a node, z fastest: 1 a seed, 0 none.   @param size  nodes along each axis, >= 1.
  /// @param low, high  the wanted part: low <= node < high; it may reach out of the box, or lie beside it.
  /// @return  its values, z fastest, valid until the next call.  O(nodes); almost free where there are no seeds.
  std::span<const float> run(std::span<const std::uint8_t> seeds, const Vec3i& size, const Vec3i& low,
                             const Vec3i& high);

 private:
  /// out(q) = min over p of in(p) + (q - p)^2, low <= q < high.
  void line(const float* in, std::ptrdiff_t in_stride, int n, float* out, std::ptrdiff_t out_stride, int low, int high);
  std::vector<float> along_z_, along_y_, out_, value_, from_, row_;
  std::vector<int> at_;
};

}  // namespace kerf::internal
