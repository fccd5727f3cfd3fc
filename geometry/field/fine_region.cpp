#include "geometry/field/fine_region.h"

#include <algorithm>
#include <cmath>

namespace kerf {

double FineRegion::depth(const Vec3d& p) const {
  double nearest = (p - line.front()).squaredNorm();
  for (std::size_t n = 1; n < line.size(); ++n) {
    const Vec3d along = line[n] - line[n - 1], from = p - line[n - 1];
    const double length = along.squaredNorm(), at = length > 0 ? std::clamp(from.dot(along) / length, 0.0, 1.0) : 0;
    nearest = std::min(nearest, (from - at * along).squaredNorm());
  }
  return radius_mm - std::sqrt(nearest);
}

Box3 FineRegion::bounds() const {
  Box3 box;
  for (const Vec3d& p : line) box.add(p);
  box.grow(radius_mm);
  return box;
}

bool FineRegion::mayMeetBrick(const Vec3i& brick) const {
  const double half = 0.5 * (kBrickSide - 1) * voxel_mm;
  const Vec3d center = voxel_mm * kBrickSide * brick.cast<double>() + Vec3d::Constant(half);
  // Half a voxel more, so that the cells between two bricks of the region have all their nodes.
  return depth(center) >= -std::sqrt(3.0) * (half + 0.5 * voxel_mm);
}

std::vector<Vec3d> thinned(const std::vector<Vec3d>& line, double spacing) {
  std::vector<Vec3d> out;
  for (std::size_t n = 0; n < line.size(); ++n)
    if (out.empty() || (line[n] - out.back()).norm() >= spacing || (n + 1 == line.size() && line[n] != out.back()))
      out.push_back(line[n]);
  return out;
}

}  // namespace kerf
