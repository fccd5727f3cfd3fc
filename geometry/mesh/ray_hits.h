// Hits of a ray on a mesh: for pointing, a few rays at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

struct RayHit {
  double way = 0;              ///< from the ray's origin, in lengths of its direction
  std::uint32_t triangle = 0;  ///< the one with the smallest number, if several meet there
  bool enters = true;          ///< through the triangle's front
};

/// All hits with way >= 0, nearest first. Where the ray meets an edge or a vertex the triangles on either side count as
/// one, if they face the same way; triangles that it runs along do not count.
/// @param direction  any length but 0.   @cost about 5 ns a triangle.   @thread any.
std::vector<RayHit> rayHits(const Mesh& mesh, const Vec3d& origin, const Vec3d& direction);

}  // namespace kerf
