// Edges of triangles as a 2-chain: their users, orientation, and boundary.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf::internal {

/// One side of a triangle: the undirected edge a < b, and true if the triangle runs from a to b.
struct EdgeUse {
  std::uint32_t a, b, triangle;
  bool forth;
};
/// All of them, sorted by (a, b, triangle). Cost: linear, and small sorts.
std::vector<EdgeUse> edgeUses(const std::vector<Triangle>& triangles);

/// Calls f(uses) for each edge, with all its uses.
template <class F>
void forEachEdge(const std::vector<EdgeUse>& uses, F&& f) {
  for (std::size_t i = 0, j = 0; i < uses.size(); i = j) {
    while (j < uses.size() && uses[j].a == uses[i].a && uses[j].b == uses[i].b) ++j;
    f(std::span(uses).subspan(i, j - i));
  }
}

/// An undirected edge a < b and how often the chain runs along it from a to b (forth) and back.
struct EdgeCount {
  std::uint32_t a, b;
  int forth, back;
};
/// All edges, sorted by (a, b). Cost: one sort.
std::vector<EdgeCount> countEdges(const std::vector<Triangle>& triangles);

/// A closed walk along the chain's boundary, in the direction the missing faces would use; no vertex twice.
using Loop = std::vector<std::uint32_t>;
std::vector<Loop> boundaryLoops(const std::vector<Triangle>& triangles);

/// Sorts the corners of a triangle by number; true if that turned it an even number of times.
bool sortCorners(Triangle& f);

/// True if every edge has one triangle on each side and the triangles at every vertex form one fan.
bool isClosedManifold(const Mesh& mesh);

}  // namespace kerf::internal
