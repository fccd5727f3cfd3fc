#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

/// A body of revolution with 16 sides about a line through `tip`: heights and radii from the tip on.
inline Mesh turned(const std::vector<std::array<double, 2>>& profile, const Vec3d& tip, const Vec3d& axis) {
  constexpr std::uint32_t kSides = 16;
  const Eigen::Quaterniond stand = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), axis);
  Mesh out;
  const auto add = [&](const Vec3d& p) { out.vertices.push_back(tip + stand * p); };
  for (const auto& [height, radius] : profile)
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const double angle = 2 * std::numbers::pi * k / kSides;
      add({radius * std::cos(angle), radius * std::sin(angle), height});
    }
  add({0, 0, profile.front()[0]});
  add({0, 0, profile.back()[0]});
  const auto rings = static_cast<std::uint32_t>(profile.size());
  const std::uint32_t low = rings * kSides, high = low + 1;
  for (std::uint32_t k = 0; k < kSides; ++k) {
    const std::uint32_t next = (k + 1) % kSides;
    out.triangles.push_back({low, next, k});
    for (std::uint32_t r = 0; r + 1 < rings; ++r) {
      const std::uint32_t a = r * kSides + k, b = r * kSides + next;
      out.triangles.push_back({a, b, b + kSides});
      out.triangles.push_back({a, b + kSides, a + kSides});
    }
    out.triangles.push_back({high, (rings - 1) * kSides + k, (rings - 1) * kSides + next});
  }
  return out;
}

}  // namespace kerf
