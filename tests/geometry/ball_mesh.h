// Test helper: a ball as a mesh.
#pragma once

#include <cmath>
#include <numbers>

#include "geometry/mesh/mesh.h"

namespace kerf {

/// Latitude-longitude ball with float32 coordinates, facing outward (or inward: the wall of a void).
inline Mesh ballMesh(const Vec3d& center, double radius, int rings, bool inward = false) {
  Mesh m;
  const int around = 2 * rings;
  const auto put = [&](const Vec3d& p) { m.vertices.push_back(roundedToFloat(Vec3d(center + radius * p))); };
  put({0, 0, 1});
  for (int r = 1; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      const double u = std::numbers::pi * r / rings, v = 2 * std::numbers::pi * a / around;
      put({std::sin(u) * std::cos(v), std::sin(u) * std::sin(v), std::cos(u)});
    }
  put({0, 0, -1});
  const auto at = [&](int r, int a) {
    return static_cast<std::uint32_t>(1 + (r - 1) * around + (a + around) % around);
  };
  const auto last = static_cast<std::uint32_t>(m.vertices.size() - 1);
  for (int a = 0; a < around; ++a) {
    m.triangles.push_back({0, at(1, a), at(1, a + 1)});
    for (int r = 1; r + 1 < rings; ++r) {
      m.triangles.push_back({at(r, a), at(r + 1, a), at(r, a + 1)});
      m.triangles.push_back({at(r, a + 1), at(r + 1, a), at(r + 1, a + 1)});
    }
    m.triangles.push_back({last, at(rings - 1, a + 1), at(rings - 1, a)});
  }
  if (inward)
    for (Triangle& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}

}  // namespace kerf
