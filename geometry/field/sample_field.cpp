#include "geometry/field/sample_field.h"

#include <algorithm>
#include <cmath>

namespace kerf {

BrickField sampleDistance(const std::function<double(const Vec3d&)>& distance, const Box3& box, double voxel,
                          double band_voxels) {
  const double band = band_voxels * voxel, brick_radius = 0.5 * std::sqrt(3.0) * (kBrickSide - 1) * voxel;
  BrickField field(voxel, static_cast<float>(band));
  Box3 grown = box;
  grown.grow(band + voxel);

  const Vec3i low = brickOf((grown.min / voxel).array().floor().cast<int>().matrix());
  const Vec3i high = brickOf((grown.max / voxel).array().ceil().cast<int>().matrix());

  BrickValues values;
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) {
        const Vec3i c(x, y, z), base = c * kBrickSide;
        const double middle = distance(field.position(base) + Vec3d::Constant(0.5 * (kBrickSide - 1) * voxel));
        if (middle > brick_radius + band) continue;
        if (middle < -brick_radius - band) {
          field.markInterior(c);
          continue;
        }

        for (int i = 0; i < kBrickSide; ++i)
          for (int j = 0; j < kBrickSide; ++j)
            for (int k = 0; k < kBrickSide; ++k)
              values[static_cast<std::size_t>(nodeOffset(i, j, k))] =
                  static_cast<float>(std::clamp(distance(field.position(base + Vec3i(i, j, k))), -band, band));
        field.add(c, values);
      }
  return field;
}

}  // namespace kerf
