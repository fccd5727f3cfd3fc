// Resolves all crossings of a triangle chain exactly: triangles that meet only at common vertices and edges.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "preprocess/close/chain.h"

namespace kerf::internal {

struct Arrangement {
  std::vector<Vec3d> points;          ///< the chain's vertices, then new ones (nearest double of an exact point)
  std::vector<Triangle> triangles;    ///< no two equal, none without area; untouched ones unchanged
  std::vector<int> multiplicity;      ///< copies of this triangle with this orientation in the chain; > 0
  std::vector<std::uint32_t> parent;  ///< the chain triangle it lies in (one of them)
  std::vector<std::vector<std::uint32_t>> twins;  ///< by entry in twin_of: all chain triangles it lies in, if several
  std::vector<std::uint32_t> twin_of;             ///< per triangle: entry in twins, or kAdded
};

/// @param pairs  crossingPairs(chain.mesh). Per pair the intersection is computed with exact numbers and becomes a
/// constraint in a constrained Delaunay triangulation of either triangle; exact points are the same vertex. Triangles
/// without area vanish, their vertices stay on their neighbours' edges. Opposite copies cancel. The scheme of Zhou,
/// Grinspun, Zorin & Jacobson, "Mesh Arrangements for Solid Geometry", SIGGRAPH 2016.
/// Errors: kGeometry if the exact arithmetic gives up; kCancelled. Cost: about 0.2 ms per pair.
Expected<Arrangement> arrangeChain(const Mesh& mesh, const std::vector<std::array<std::uint32_t, 2>>& pairs,
                                   const Progress& progress);

/// The boundary of {winding number >= 1} of the chain, oriented outwards: triangles of the arrangement to keep.
struct Kept {
  std::vector<char> keep;
  std::size_t patches = 0, patches_kept = 0;
};
/// @pre the chain is closed. Errors: kGeometry if winding numbers are not whole (the chain was not closed); kCancelled.
Expected<Kept> keepWindingBoundary(const Mesh& chain, const Arrangement& arrangement, const Progress& progress);

}  // namespace kerf::internal
