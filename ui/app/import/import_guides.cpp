#include "ui/app/import/import_guides.h"

#include <algorithm>
#include <cmath>

namespace kerf {

std::array<Vec3d, 4> rectangleOf(const Plane& plane, const Box3& box) {
  // Directions: along the axis most parallel to the plane, and across.
  const Vec3d n = plane.normal.normalized();
  Eigen::Index axis = 0;
  n.cwiseAbs().minCoeff(&axis);
  Vec3d u = Vec3d::Unit(axis);
  u = (u - u.dot(n) * n).normalized();
  const Vec3d v = n.cross(u);

  const Vec3d middle = box.center() - n * n.dot(box.center() - plane.point);
  double half_u = 0, half_v = 0;
  for (int k = 0; k < 8; ++k) {
    half_u = std::max(half_u, std::abs(u.dot(box.corner(k) - middle)));
    half_v = std::max(half_v, std::abs(v.dot(box.corner(k) - middle)));
  }
  u *= half_u;
  const Vec3d aside = half_v * v;
  return {middle + u + aside, middle - u + aside, middle - u - aside, middle + u - aside};
}

}  // namespace kerf
