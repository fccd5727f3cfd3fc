// Patch: the triangles of a mesh near another one, as a closed mesh for a boolean; its result is sewn to the rest
// again.
//
// CGAL takes only closed meshes, and processes every triangle. So caps that do not meet the other mesh close the patch:
// the crossings of the surfaces then decide the result, as in the whole mesh.
//
//        ___                            ^
//       |   | other                   /   \   a cap: a cone over each loop of the patch's border
//   ----+   +----  source   =>    ---+   +---
//       |___|                     patch, closed
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/boolean/boolean.h"
#include "geometry/mesh/mesh.h"

namespace kerf::internal {

struct NearPatch {
  Mesh mesh;  ///< closed; vertices and triangles of the source in its order, then those of the caps
  /// Per vertex and per triangle: the number in the source, or kNoSource for a cap.
  std::vector<std::uint32_t> vertex, triangle;
  std::size_t source_triangles = 0;  ///< the first triangles, without the caps
};

/// All triangles of the source outside of the patch lie outside `other`, at least two of its triangles' sizes from its
/// surface.
/// @pre both closed, 2-manifold; the caller checks for self-intersections in the patch.
/// Caps may cross each other and the patch, without a crossing of the source.
/// @return empty if the boolean has to take the whole source: it is open, the patch is more than half of it or empty,
/// or a loop of its border has no cap clear of `other` (which links with the loop, as in a chain).
/// @cost  about 20 ms for 300k triangles and another mesh of 20k. @thread any; deterministic.
std::optional<NearPatch> nearPatch(const Mesh& source, const Mesh& other);

/// Replaces the patch by its boolean result: vertices and triangles in the order of the boolean of the whole source.
/// @return empty if the boolean changed a cap.   @cost  O(n), 10 ns a triangle.
std::optional<Difference> sewnToRest(const Mesh& source, const NearPatch& patch, const Difference& near);

/// True if no triangle has a point in common with a box. May be false without a common point, for triangles within a
/// billionth of the box's coordinates.
bool isApart(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Box3& box);

}  // namespace kerf::internal
