// Self-intersection of a triangle mesh, decided exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

inline constexpr std::size_t kAllPairs = std::numeric_limits<std::size_t>::max();

/// Pairs of triangles that meet anywhere else than in the vertex or edge they share.
/// Sharing is by INDEX, so weld equal positions first. What counts, for a pair sharing
///   no vertex:     any common point, touching included;
///   one vertex:    any common point besides that vertex;
///   an edge:       lying folded over each other in one plane;
///   all three:     always (the same face twice).
/// Triangles of exactly zero area (see degenerateTriangles) take no part.
///
/// Candidates come from a tree of boxes over the triangles in Morton order; a separating plane in double with a
/// rounding bound rejects most candidates; exact predicates decide the rest. No tolerance anywhere.
/// @param vertices    finite, any unit.    @param triangles  indices in range.
/// @param stop_after  at most this many pairs are returned; a small number makes the answer to "does it cross itself at
///                    all" cheap. Their selection does not depend on the number of threads.
/// @return pairs (i < j), sorted; complete unless stop_after cut it short.
/// @cost   O(n log n + candidates), parallel; on two cores 35 ms for 60 000 triangles, 80-110 ms for 200 000.
std::vector<std::pair<std::uint32_t, std::uint32_t>> selfIntersections(std::span<const Vec3d> vertices,
                                                                       std::span<const Triangle> triangles,
                                                                       std::size_t stop_after = kAllPairs);

/// The pairs of selfIntersections() with a chosen triangle in them: all that can be new where only these have changed.
/// @param chosen  per triangle.
/// @cost   O(n + candidates), parallel: a fifth of selfIntersections() where few are chosen.
std::vector<std::pair<std::uint32_t, std::uint32_t>> selfIntersectionsOf(std::span<const Vec3d> vertices,
                                                                         std::span<const Triangle> triangles,
                                                                         std::span<const char> chosen);

/// Triangles whose three corners lie exactly on one line (or coincide), in order.
std::vector<std::uint32_t> degenerateTriangles(std::span<const Vec3d> vertices, std::span<const Triangle> triangles);

}  // namespace kerf
