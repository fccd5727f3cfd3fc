// Region with smaller voxels: the neighbourhood of a line, such as that of an osteotomy.
#pragma once

#include <vector>

#include "geometry/base/types.h"
#include "geometry/field/brick_field.h"

namespace kerf {

/// Suffix of the fine grids in a case: phi_fine, material_fine, shell_fine.
inline constexpr const char* kFineSuffix = "_fine";

/// All points within `radius_mm` of a polyline. Object frame.
struct FineRegion {
  std::vector<Vec3d> line;  ///< mm, at least one point; one alone: a ball
  double radius_mm = 0;     ///< > 0
  double voxel_mm = 0;      ///< voxel size of the fine grids; smaller than the object's

  /// Depth of a point inside the region, mm; negative outside. O(points of the line).
  double depth(const Vec3d& p) const;
  Box3 bounds() const;
  /// True for bricks of the fine grid that may hold a point of the region: those the fine grids store.
  bool mayMeetBrick(const Vec3i& brick) const;
};

/// The same line with fewer points: drops points closer than `spacing` to the previous one, keeps the ends.
/// A recorded path has thousands. O(n).
std::vector<Vec3d> thinned(const std::vector<Vec3d>& line, double spacing);

}  // namespace kerf
