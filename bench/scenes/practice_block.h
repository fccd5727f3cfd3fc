// A block of one material to practise on and to measure with: no scan, no files, any attitude to the grid.
#pragma once

#include <functional>

#include "sim/object/baked_object.h"
#include "sim/step/tool_model.h"

namespace kerf {

/// A solid by its 1-Lipschitz distance (mm, negative inside), as a case would be baked: 3 voxels outside,
/// max(4 voxels, 0.2 mm) inside.   @param box  contains it, mm.
Expected<std::shared_ptr<const BakedObject>> bakedFrom(const std::function<double(const Vec3d&)>& distance,
                                                       const Box3& box, double voxel,
                                                       Material material = Material::kDentin);

/// A block centred under the origin, its top at z = 0 of its own frame, which `attitude` turns and moves. mm.
Expected<std::shared_ptr<const BakedObject>> practiceBlock(const Vec3d& size, double voxel, const Rigid3& attitude = {},
                                                           Material material = Material::kDentin);

/// A ball bur of that radius, its tip at the origin, whose surface moves at `speed` mm/s everywhere, as a stroke's
/// does: what has a formula. No drive to stall, no neck.
ToolModel practiceBall(double radius, double speed);

}  // namespace kerf
