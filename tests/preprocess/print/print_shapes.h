// Solids with known pockets, undercuts and walls.
#pragma once

#include <cmath>
#include <vector>

#include "tests/preprocess/solid_checks.h"

namespace kerf::test {

/// Solid of revolution about z. @param profile  (r, z), counter-clockwise in the r-z plane; r = 0 on the axis.
/// Without an end on the axis the profile is closed: a ring.
inline Mesh revolved(const std::vector<Eigen::Vector2d>& profile, int sectors = 256) {
  Mesh out;
  std::vector<std::vector<std::uint32_t>> rows;
  for (const Eigen::Vector2d& p : profile) {
    std::vector<std::uint32_t> row;
    for (int j = 0; j < (p[0] > 0 ? sectors : 1); ++j) {
      const double a = 2 * M_PI * j / sectors;
      row.push_back(static_cast<std::uint32_t>(out.vertices.size()));
      out.vertices.push_back({p[0] * std::cos(a), p[0] * std::sin(a), p[1]});
    }
    row.resize(static_cast<std::size_t>(sectors), row.front());
    rows.push_back(row);
  }
  const bool is_ring = profile.front()[0] > 0;
  for (std::size_t i = 0; i + (is_ring ? 0 : 1) < rows.size(); ++i)
    for (std::size_t j = 0; j < static_cast<std::size_t>(sectors); ++j) {
      const auto &low = rows[i], &high = rows[(i + 1) % rows.size()];
      const std::size_t k = (j + 1) % static_cast<std::size_t>(sectors);
      if (low[j] != low[k]) out.triangles.push_back({low[j], low[k], high[j]});
      if (high[j] != high[k]) out.triangles.push_back({low[k], high[k], high[j]});
    }
  return out;
}

/// Points on the arc of radius r about (0, 0) from angle a to b, rad, in the r-z plane.
inline void addArc(std::vector<Eigen::Vector2d>& profile, double r, double a, double b, int steps = 64) {
  for (int i = 0; i <= steps; ++i) {
    const double angle = a + (b - a) * i / steps, x = r * std::cos(angle);
    profile.push_back({std::abs(x) < 1e-12 ? 0.0 : x, r * std::sin(angle)});
  }
}

inline Mesh turned(Mesh mesh, const Eigen::Matrix3d& turn, const Vec3d& shift = Vec3d::Zero()) {
  for (Vec3d& p : mesh.vertices) p = turn * p + shift;
  return mesh;
}
/// Rotations for tests: none, then turned by no simple angle.
inline std::vector<Eigen::Matrix3d> turns() {
  std::vector<Eigen::Matrix3d> out{Eigen::Matrix3d::Identity()};
  for (int n = 1; n < 5; ++n)
    out.push_back(
        Eigen::AngleAxisd(1.37 * n, Vec3d(0.3 * n - 0.7, 0.51, 0.2 + 0.11 * n).normalized()).toRotationMatrix());
  return out;
}

}  // namespace kerf::test
