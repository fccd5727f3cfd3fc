#include "ui/app/saw/saw_contour.h"

#include <cmath>

namespace kerf {

std::vector<std::array<Vec3d, 2>> contourOf(const SawPlane& plane, const LiveScene& scene) {
  constexpr double kMargin = 0.1;  // mm: the box has a thickness
  Box3 box;
  for (const Vec3d& corner : plane.corners()) box.add(corner);
  box.grow(kMargin);

  const auto isWithin = [&](const Vec3d& p) {
    const Vec3d at = plane.toPlane(p);
    return std::abs(at[0]) <= 0.5 * plane.width && at[1] >= 0 && at[1] <= plane.depth;
  };
  std::vector<std::array<Vec3d, 2>> out;
  for (const auto& piece : scene.contour({plane.point, plane.normal}, box))
    if (isWithin(piece[0]) && isWithin(piece[1])) out.push_back(piece);
  return out;
}

}  // namespace kerf
