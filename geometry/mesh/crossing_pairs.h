// Pairs of triangles that meet elsewhere than at their shared vertices and edges: exact, for float or double.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "geometry/mesh/self_intersection.h"

namespace kerf {

/// selfIntersections() and, besides, every triangle without area: as the pair (i, i), and with each proper triangle it
/// touches away from shared vertices. An empty answer means the mesh is embedded.
/// @return sorted pairs (i <= j). Exact; deterministic.
/// @param stop_after  as in selfIntersections(): with more pairs the result is incomplete, and its selection may
/// differ.
/// @cost   as selfIntersections(), plus a search in a tree of the triangles without area. @thread any; uses all
/// TBB threads.
std::vector<std::array<std::uint32_t, 2>> crossingPairs(const Mesh& mesh, std::size_t stop_after = kAllPairs);

/// The pairs of crossingPairs() with a chosen triangle in them.   @param chosen  per triangle.
/// @cost  as selfIntersectionsOf(): little where few are chosen.
std::vector<std::array<std::uint32_t, 2>> crossingPairsOf(const Mesh& mesh, const std::vector<char>& chosen);

}  // namespace kerf
