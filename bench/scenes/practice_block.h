// A block of one material for practice and measurement: no scan, no files, any attitude to the grid.
#pragma once

#include <functional>

#include "sim/object/baked_object.h"
#include "sim/step/tool_model.h"

namespace kerf {

/// A solid from a 1-Lipschitz distance (mm, negative inside), with the band of a baked case: 3 voxels outside, max(4
/// voxels, 0.2 mm) inside.   @param box  contains it, mm.
Expected<std::shared_ptr<const BakedObject>> bakedFrom(const std::function<double(const Vec3d&)>& distance,
                                                       const Box3& box, double voxel,
                                                       Material material = Material::kDentin);

/// A block centred under the origin, with its top at z = 0 of its own frame. `attitude` places that frame. mm.
Expected<std::shared_ptr<const BakedObject>> practiceBlock(const Vec3d& size, double voxel, const Rigid3& attitude = {},
                                                           Material material = Material::kDentin);

/// A ball bur of that radius with its tip at the origin. Its surface moves at `speed` mm/s everywhere, as a stroke's
/// does, so formulas apply. No drive that could stall, no neck.
ToolModel practiceBall(double radius, double speed);

}  // namespace kerf
