// The flat face that a model stands on.
#pragma once

#include <optional>

#include "geometry/base/types.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct BaseFace {
  Plane plane;  ///< the normal points out of the model: down, for a model that stands on it
  double area_mm2 = 0;
};

/// The largest flat face with the whole solid on one side, to within 0.05 mm. Empty if none has 2 % of the surface and
/// 20 mm2: the model has no base.
/// @param down  a face towards this direction, within 25 degrees, comes before larger ones elsewhere. Zero: none does.
/// @pre closed, outward, mm.   @cost  20 ms for 300k triangles. @thread any; deterministic.
std::optional<BaseFace> findBase(const Mesh& solid, const Vec3d& down = Vec3d::Zero());

}  // namespace kerf
