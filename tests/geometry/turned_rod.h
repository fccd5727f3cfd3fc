// Test helper: a bur or a handpiece as a mesh.
#pragma once

#include <array>
#include <vector>

#include "bench/scenes/fluted_mesh.h"

namespace kerf {

/// A body of revolution with 16 sides about a line through `tip`: heights and radii from the tip on.
inline Mesh turned(const std::vector<std::array<double, 2>>& profile, const Vec3d& tip, const Vec3d& axis) {
  constexpr std::uint32_t kSides = 16;
  const Eigen::Quaterniond stand = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), axis);
  const auto put = [&](double radius, double height, std::uint32_t side) {
    const double angle = 2 * std::numbers::pi * side / kSides;
    return Vec3d(tip + stand * Vec3d(radius * std::cos(angle), radius * std::sin(angle), height));
  };
  const auto at = [&](std::uint32_t ring, std::uint32_t side) { return put(profile[ring][1], profile[ring][0], side); };
  return ringMesh(kSides, static_cast<std::uint32_t>(profile.size()), at, put(0, profile.front()[0], 0),
                  put(0, profile.back()[0], 0));
}

/// A bur of 1.4 mm in a thick handle, its tip at (3, -2, 5), its shank towards -y.
inline constexpr double kBurLength = 3.2;
inline Mesh handpiece() {
  return turned({{0, 0.7}, {kBurLength, 0.7}, {kBurLength + 0.5, 5}, {30, 6}}, {3, -2, 5}, -Vec3d::UnitY());
}

}  // namespace kerf
