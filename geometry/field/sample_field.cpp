#include "geometry/field/sample_field.h"

#include <algorithm>
#include <cmath>

namespace kerf {

namespace {

// Calls visit(brick, is_deep_inside) for all bricks not outside, until it returns false.
template <class Visit>
void forEachBrick(const std::function<double(const Vec3d&)>& distance, const Box3& box, double voxel, double band,
                  const Progress& progress, const Visit& visit) {
  const double brick_radius = 0.5 * std::sqrt(3.0) * (kBrickSide - 1) * voxel;
  const Vec3d to_middle = Vec3d::Constant(0.5 * (kBrickSide - 1) * voxel);
  Box3 grown = box;
  grown.grow(band + voxel);
  const Vec3i low = brickOf((grown.min / voxel).array().floor().cast<int>().matrix());
  const Vec3i high = brickOf((grown.max / voxel).array().ceil().cast<int>().matrix());

  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y) {
      if (!report(progress, static_cast<double>(x - low[0]) / (high[0] - low[0] + 1), "sampling")) return;
      for (int z = low[2]; z <= high[2]; ++z) {
        const Vec3i c(x, y, z);
        const double middle = distance((c * kBrickSide).cast<double>() * voxel + to_middle);
        const double away = middle - brick_radius - band;
        if (away > 0)
          z += static_cast<int>(std::min(away / (kBrickSide * voxel) * (1 - 1e-9), 1e6));  // 1-Lipschitz
        else if (!visit(c, middle < -brick_radius - band))
          return;
      }
    }
}

}  // namespace

std::size_t countSampledBricks(const std::function<double(const Vec3d&)>& distance, const Box3& box, double voxel,
                               std::size_t most, const Progress& progress, double band_voxels) {
  std::size_t count = 0;
  forEachBrick(distance, box, voxel, band_voxels * voxel, progress,
               [&](const Vec3i&, bool is_inside) { return (count += is_inside ? 0 : 1) < most; });
  return count;
}

BrickField sampleDistance(const std::function<double(const Vec3d&)>& distance, const Box3& box, double voxel,
                          double band_voxels, const Progress& progress) {
  const double band = band_voxels * voxel;
  BrickField field(voxel, static_cast<float>(band));
  BrickValues values;
  forEachBrick(distance, box, voxel, band, progress, [&](const Vec3i& c, bool is_inside) {
    if (is_inside) {
      field.markInterior(c);
      return true;
    }
    const Vec3i base = c * kBrickSide;
    for (int i = 0; i < kBrickSide; ++i)
      for (int j = 0; j < kBrickSide; ++j)
        for (int k = 0; k < kBrickSide; ++k)
          values[static_cast<std::size_t>(nodeOffset(i, j, k))] =
              static_cast<float>(std::clamp(distance(field.position(base + Vec3i(i, j, k))), -band, band));
    field.add(c, values);
    return true;
  });
  return field;
}

}  // namespace kerf
