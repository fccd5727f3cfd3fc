// Tools as meshes: a head with flutes, a tube.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

/// Rings of points at(ring, side), closed with a point at either end.
template <class At>
Mesh ringMesh(std::uint32_t sides, std::uint32_t rings, const At& at, const Vec3d& low, const Vec3d& high) {
  Mesh out;
  for (std::uint32_t r = 0; r < rings; ++r)
    for (std::uint32_t a = 0; a < sides; ++a) out.vertices.push_back(at(r, a));
  const std::uint32_t last = rings * sides;
  out.vertices.push_back(low);
  out.vertices.push_back(high);
  for (std::uint32_t a = 0; a < sides; ++a) {
    const std::uint32_t next = (a + 1) % sides, top = (rings - 1) * sides;
    out.triangles.push_back({last, next, a});
    for (std::uint32_t r = 0; r + 1 < rings; ++r) {
      const std::uint32_t p = r * sides + a, q = r * sides + next;
      out.triangles.push_back({p, q, q + sides});
      out.triangles.push_back({p, q + sides, p + sides});
    }
    out.triangles.push_back({last + 1, top + a, top + next});
  }
  return out;
}

struct Flutes {
  std::uint32_t sides = 128, rings = 60;  ///< 15 000 triangles
  double depth = 0.25;                    ///< of the radius
  double pitch_mm = 12;                   ///< height of a turn
};

/// A head with eight helical flutes along +z, its tip at the origin; the edges between flutes follow radius_at(z).
template <class RadiusAt>
Mesh flutedMesh(const RadiusAt& radius_at, double length, const Flutes& f = {}) {
  const auto at = [&](std::uint32_t r, std::uint32_t a) {
    // Both ends stay off the axis.
    const double z = length * (r + 0.02) / (f.rings - 0.96), turn = 2 * std::numbers::pi * a / f.sides;
    const double radius = radius_at(z) * (1 - f.depth * std::abs(std::sin(4 * turn)));
    const double angle = turn + 2 * std::numbers::pi * z / f.pitch_mm;
    return Vec3d(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  return ringMesh(f.sides, f.rings, at, {0, 0, 0}, {0, 0, length});
}

/// A round rod of `sides` sides along +z from the origin, hollow from its end to a height; without a hollow: deep = 0.
inline Mesh tubeMesh(double outer, double inner, double deep, double length, std::uint32_t sides) {
  const auto on = [&](double radius, double z, std::uint32_t a) {
    const double angle = 2 * std::numbers::pi * a / sides;
    return Vec3d(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  if (deep == 0)
    return ringMesh(sides, 2, [&](std::uint32_t r, std::uint32_t a) { return on(outer, r == 0 ? 0 : length, a); },
                    {0, 0, 0}, {0, 0, length});
  const double radii[] = {inner, inner, outer, outer}, heights[] = {deep, 0, 0, length};
  return ringMesh(sides, 4, [&](std::uint32_t r, std::uint32_t a) { return on(radii[r], heights[r], a); }, {0, 0, deep},
                  {0, 0, length});
}

}  // namespace kerf
