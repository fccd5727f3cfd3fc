#include "geometry/tool/mesh_shape.h"

#include <algorithm>

namespace kerf {

double HalfShape::distance(const Vec3d& p) const noexcept { return std::max(solid_->distance(p), level_ - p[2]); }

Box3 HalfShape::bounds() const {
  Box3 box = solid_->bounds();
  box.min[2] = std::max(box.min[2], level_);
  return box;
}

}  // namespace kerf
