// Generalized winding number of a triangle chain, summed exactly over all triangles.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf::internal {

/// Sum of the signed solid angles of the triangles seen from p, over 4 pi: 1 inside a closed outward surface, 0
/// outside. Skips triangles t with skip[t] != 0 (skip may be empty). After van Oosterom & Strackee, IEEE Trans. Biomed.
/// Eng. 30, 1983, and Jacobson, Kavan & Sorkine-Hornung, SIGGRAPH 2013. Cost: 30 ns per triangle.
double windingNumber(const Mesh& mesh, const Vec3d& p, std::span<const char> skip = {});
/// The same, leaving out the few triangles listed.
double windingNumberExcept(const Mesh& mesh, const Vec3d& p, std::span<const std::uint32_t> except);

/// The same for closed surfaces, many times over: counts the crossings of a ray. The constructor sorts the triangles
/// into a grid across the ray, O(triangles). A query costs the triangles of one cell.
class RayWinding {
 public:
  /// @param mesh  closed.
  explicit RayWinding(const Mesh& mesh);
  /// Direction of the rays: along no common plane of grids, so that few rays graze an edge.
  const Vec3d& direction() const { return direction_; }
  /// Mean number of triangles that at() tests.
  double trianglesOfACell() const {
    return static_cast<double>(triangle_.size()) / static_cast<double>(first_.size() - 1);
  }
  /// Winding number of all triangles except those with skip(t) true; a point on a skipped triangle counts as on the
  /// side that the ray goes to. Empty if the ray grazes an edge, or p lies on the surface.
  std::optional<int> at(const Vec3d& p, const std::function<bool(std::uint32_t)>& skip) const;

 private:
  std::size_t cellOf(double y, double z) const;
  Mesh mesh_;  // turned: rays go along +x
  Eigen::Matrix3d turn_;
  Vec3d direction_, low_ = Vec3d::Zero();
  double cell_ = 1;  // mm
  std::size_t ny_ = 1, nz_ = 1;
  std::vector<std::uint32_t> first_, triangle_;  // cell c: triangle_[first_[c] .. first_[c + 1])
};

}  // namespace kerf::internal
