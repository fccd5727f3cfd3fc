// Distance formulas sampled on a grid: test blocks, baked tools.
#pragma once

#include <functional>

#include "geometry/base/progress.h"
#include "geometry/field/brick_field.h"

namespace kerf {

/// Samples a 1-Lipschitz signed distance (mm, negative inside) in all bricks within `band_voxels` of its surface;
/// bricks farther in are marked as interior.
/// @param box  contains the solid, mm.   @param voxel  mm, > 0.   @param progress  cancelled: the field lacks bricks.
BrickField sampleDistance(const std::function<double(const Vec3d&)>& distance, const Box3& box, double voxel,
                          double band_voxels = 4, const Progress& progress = {});

/// The bricks of such a field that hold values; not more than `most`. 512 times as fast as sampling.
std::size_t countSampledBricks(const std::function<double(const Vec3d&)>& distance, const Box3& box, double voxel,
                               std::size_t most, const Progress& progress = {}, double band_voxels = 4);

}  // namespace kerf
