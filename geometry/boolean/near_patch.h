// The triangles of a mesh that a boolean with another can change, as a closed mesh of their own; what the boolean makes
// of them sewn to the rest again.
//
// CGAL takes closed meshes alone, and goes through all of them. The patch is therefore closed by caps that do not meet
// the other mesh: what becomes of the patch is then decided where the surfaces cross, as in the whole mesh.
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
  /// Per vertex and per triangle: the number in the source, or kNoSource: of a cap.
  std::vector<std::uint32_t> vertex, triangle;
  std::size_t source_triangles = 0;  ///< the first of them, which are no caps
};

/// All triangles of the source outside of the patch lie outside `other`, at least two of its triangles' sizes from its
/// surface.
/// @pre both closed, 2-manifold; whether they cross themselves in the patch is for the caller to look at.
/// Caps may cross each other, and the patch: that is no crossing of the source.
/// @return none where the boolean has to take the whole source: it is open, the patch is more than half of it or empty,
/// or a loop of its border has no cap that stays clear of `other` (that goes through the loop and around its rim, as
/// the link of a chain).
/// @cost  about 20 ms for 300k triangles and another mesh of 20k. @thread any; deterministic.
std::optional<NearPatch> nearPatch(const Mesh& source, const Mesh& other);

/// What a boolean made of the patch, in the place of the patch: vertices and triangles in the order in which the
/// boolean of the whole source has them.
/// @return none if a cap is not as it was: the boolean has met it.   @cost  O(n), 10 ns a triangle.
std::optional<Difference> sewnToRest(const Mesh& source, const NearPatch& patch, const Difference& near);

/// True if no triangle has a point in common with a box. May be false for some that have none: for those that come
/// within a billionth of the box's coordinates.
bool isApart(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Box3& box);

}  // namespace kerf::internal
