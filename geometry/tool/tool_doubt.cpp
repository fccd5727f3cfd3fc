#include "geometry/tool/tool_doubt.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/mesh/mesh.h"

namespace kerf {
namespace {

// A mesh tool turns about its axis. If it is long in another direction, or lies beside its axis, the axis is probably
// wrong.
std::string doubtAboutAxis(const Mesh& mesh) {
  double area = 0;
  Vec3d middle = Vec3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double weight = doubleAreaVector(mesh, t).norm();
    middle += weight / 3 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2));
    area += weight;
  }
  if (!(area > 0)) return {};
  middle /= area;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    // Covers all points of a triangle, not only its middle: a rod may be a box of twelve.
    const double weight = doubleAreaVector(mesh, t).norm() / area / 12;
    Vec3d sum = Vec3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vec3d d = mesh.corner(t, k) - middle;
      spread += weight * d * d.transpose();
      sum += d;
    }
    spread += weight * sum * sum.transpose();
  }

  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  const Vec3d lengths = axes.eigenvalues().cwiseMax(0.0).cwiseSqrt(), longest = axes.eigenvectors().col(2);
  constexpr double kSlender = 2, kMostDegrees = 3, kMostOff = 0.25;
  const double degrees = std::acos(std::min(1.0, std::abs(longest[2]))) * 180 / std::numbers::pi;
  if (lengths[2] > kSlender * lengths[1] && degrees > kMostDegrees)
    return fmt::format(
        "the mesh is longest {:.0f} degrees off its axis: check that `axis` points from the tip to the shank", degrees);
  const double off = middle.head<2>().norm();
  if (off > kMostOff * std::max(lengths[1], 0.1))
    return fmt::format("the middle of the mesh is {:.2f} mm off its axis: check that `tip` is on the axis", off);
  return {};
}

}  // namespace

std::string doubtAbout(const Tool& tool) {
  if (tool.mesh) return doubtAboutAxis(*tool.mesh);
  constexpr double kWideHead = 8;  // mm; the rack's widest has 4
  if (tool.kind != ToolKind::kBur || tool.head_diameter_mm < kWideHead) return {};
  return fmt::format(
      "a head {:.3g} mm wide is unusual: ISO 6360 counts in tenths of a millimetre, so that 016 is 1.6 mm",
      tool.head_diameter_mm);
}

}  // namespace kerf
