// Distance formulas sampled on a grid: test blocks, baked tools.
#pragma once

#include <functional>

#include "geometry/field/brick_field.h"

namespace kerf {

/// Samples a 1-Lipschitz signed distance (mm, negative inside) in all bricks within `band_voxels` of its surface;
/// bricks farther in are marked as interior.
/// @param box  contains the solid, mm.   @param voxel  mm, > 0.
BrickField sampleDistance(const std::function<double(const Vec3d&)>& distance, const Box3& box, double voxel,
                          double band_voxels = 4);

}  // namespace kerf
