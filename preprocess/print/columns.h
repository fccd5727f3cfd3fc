// Vertical columns through a mesh: the exact heights where a grid of parallel lines crosses its surface.
#pragma once

#include <cstdint>
#include <functional>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf::internal {

/// A square grid of lines along an axis, with one free line around the mesh. Frame coordinates: x and y across the
/// axis, z along it, mm. Line (i, j) is number j * nx + i.
class ColumnGrid {
 public:
  /// Fails unless the axis is a unit vector, the mesh is not empty and smaller than 10 m, and the grid has at most
  /// 50 million lines.
  static Expected<ColumnGrid> around(const Mesh& mesh, const Vec3d& axis, double voxel_mm);

  int nx() const { return nx_; }
  int ny() const { return ny_; }
  std::size_t count() const { return static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_); }
  double voxel() const { return voxel_; }
  const Box3& box() const { return box_; }  ///< of the mesh, frame coordinates

  Vec3d toFrame(const Vec3d& p) const { return turn_ * p; }
  Vec3d fromFrame(const Vec3d& p) const { return turn_.transpose() * p; }
  /// Point of a line, mesh frame.
  Vec3d place(std::size_t line, double z) const {
    const auto i = static_cast<int>(line % static_cast<std::size_t>(nx_));
    const auto j = static_cast<int>(line / static_cast<std::size_t>(nx_));
    return fromFrame({lineX(i), lineY(j), z});
  }
  double lineX(int i) const { return low_[0] + (i + 0.5) * voxel_; }
  double lineY(int j) const { return low_[1] + (j + 0.5) * voxel_; }

  /// Calls hit(line, z, enters) for each crossing of a line with a triangle, triangle by triangle; `enters`: the line,
  /// followed along the axis, goes through the front of the triangle. The test is exact after rounding x and y to
  /// 2^-16 mm, and a line through an edge or a vertex counts as shifted by less than any length (Edelsbrunner & Muecke
  /// 1990): on a closed mesh every line enters as often as it leaves.
  /// @return false when cancelled.
  bool eachCrossing(const Mesh& mesh, const Progress& progress,
                    const std::function<void(std::size_t line, double z, bool enters)>& hit) const;

 private:
  Eigen::Matrix3d turn_ = Eigen::Matrix3d::Identity();
  Box3 box_;
  Vec3d low_ = Vec3d::Zero();  // corner of the grid
  double voxel_ = 1;
  int nx_ = 0, ny_ = 0;
};

/// The error of a line that enters more often than it leaves, or less often.
tl::unexpected<Error> openAt(const ColumnGrid& grid, std::size_t line, double z);

/// Requires length 1 within 1e-6. @param place  name of the axis for the error.
Expected<void> checkAxis(const Vec3d& axis, const char* place);

}  // namespace kerf::internal
