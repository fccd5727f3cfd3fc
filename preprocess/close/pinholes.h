// Pinholes: short tunnels through a solid, caused by its base. Below a steep rim the wall folds over the scan's own
// edge. Between the two remains a tunnel some hundredths of a mm to a few mm round.
//
// Detection: the handles of a surface carry closed walks that bound nothing. Through a root, the shortest such walks
// come from a tree of shortest ways and a tree of triangles that share an edge outside of it, the edges of the longest
// walks first; each edge in neither tree closes one walk (Erickson & Whittlesey, Greedy optimal homotopy and homology
// generators, SODA 2005). The search then moves the roots to these walks.
// Repair: a lens, thinner than wide, across the tunnel is united with the solid.
#pragma once

#include <vector>

#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf::internal {

/// A closed walk that bounds nothing, along the edges of a solid.
struct ShortLoop {
  std::vector<std::uint32_t> vertices;
  double length = 0;  ///< mm
  Vec3d middle = Vec3d::Zero();
  bool is_tunnel = false;  ///< the middle lies outside of the solid: a hole through it; else a thread of material
};

/// Closed walks not longer than `longest_mm` that bound nothing, at most one through a place, shortest first; may miss
/// some.
/// @pre solid is a closed 2-manifold.   @cost 0.05 s per handle and 50 000 triangles. Empty if cancelled.
std::vector<ShortLoop> shortLoops(const Mesh& solid, double longest_mm, const Progress& progress);

/// A closed surface across a tunnel, facing outwards: two shallow cones over a ring on the surface beside the loop, let
/// a little into the solid; its vertices are not in it. Across a thread: the volume to remove, facing inwards.
/// @param is_left  which side of the loop the ring lies on.   @return empty where there is no such ring.
Mesh plugOf(const Mesh& solid, const ShortLoop& loop, bool is_left);

}  // namespace kerf::internal
