// Rays against a mesh, tested on every triangle: for measurements of the demo anatomy.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

/// Distances of the hits on the mesh along the ray from `from` in the (unit) direction, ascending, mm.
inline std::vector<double> rayCrossings(const Mesh& mesh, const Vec3d& from, const Vec3d& direction) {
  std::vector<double> hits;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d a = mesh.corner(t, 0), e1 = mesh.corner(t, 1) - a, e2 = mesh.corner(t, 2) - a;
    const Vec3d h = direction.cross(e2), s = from - a, q = s.cross(e1);
    const double det = e1.dot(h), u = s.dot(h) / det, v = direction.dot(q) / det, along = e2.dot(q) / det;
    if (std::abs(det) > 1e-12 && u >= 0 && v >= 0 && u + v <= 1 && along > 0) hits.push_back(along);
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

/// Whether a point lies in a closed mesh: an odd number of crossings on a ray askew to any lattice.
inline bool isInside(const Mesh& mesh, const Vec3d& p) {
  return rayCrossings(mesh, p, Vec3d(0.3137, 0.2971, 0.9019).normalized()).size() % 2 == 1;
}

/// Distance from a point to the nearest vertex of a mesh, mm.
inline double distanceToVertices(const Mesh& mesh, const Vec3d& p) {
  double nearest = 1e300;
  for (const Vec3d& q : mesh.vertices) nearest = std::min(nearest, (q - p).squaredNorm());
  return std::sqrt(nearest);
}

/// Bounds of the part between the planes `low` <= p[axis] <= `high`.
inline Box3 boundsBetween(const Mesh& mesh, int axis, double low, double high) {
  Box3 box;
  for (const Vec3d& p : mesh.vertices)
    if (p[axis] >= low && p[axis] <= high) box.add(p);
  return box;
}

}  // namespace kerf
