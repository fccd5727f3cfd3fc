// Which triangles of a mesh meet elsewhere than at the vertices and edges they share: exact answers, for float or
// double.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/mesh.h"

namespace kerf {

/// Pairs (i < j) of triangles whose intersection is more than their common vertices (by index) or their common edge:
/// crossing, touching in a point, folded onto each other, equal. A triangle without area (three collinear corners, or a
/// repeated index) is reported as the pair (i, i) and again with every triangle it touches apart from shared vertices.
/// Vertices are told apart by index: two vertices at the same place make their triangles touch, and are reported.
/// @param only  empty, or one flag per triangle: only pairs with at least one flagged triangle are looked for.
/// @return sorted pairs; empty for a mesh that is embedded. Exact (filtered predicates); deterministic.
/// @cost   about 0.6 us per triangle and core for a scan. @thread any; uses all TBB threads.
std::vector<std::array<std::uint32_t, 2>> crossingPairs(const Mesh& mesh, const std::vector<char>& only = {});

}  // namespace kerf
