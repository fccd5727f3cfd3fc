// Separates the parts of a solid that touch each other only along edges or in vertices.
#pragma once

#include "geometry/mesh/mesh.h"

namespace kerf::internal {

struct SplitReport {
  std::vector<std::uint32_t> copy_of;  ///< per new vertex: the vertex it was split from (kAdded: middle of an edge)
  std::size_t places = 0;              ///< vertices that were split
};

/// Makes an embedded boundary (every edge balanced, outward) a 2-manifold. At an edge with four or more triangles those
/// that bound the same wedge of material belong together; a vertex gets one copy per fan. The largest fan keeps the
/// vertex, the copies move into their material by `distance`, because files know positions only. If neither end of an
/// edge can be split, the edge gets a vertex in the middle. Keeps the triangle order; triangles made at such a middle
/// come last.
/// @param normals_of  per triangle an exact-enough normal (of the triangle it was cut from). Follows the triangles.
/// @param tags        per triangle labels that follow the triangles.
SplitReport splitNonManifold(Mesh& mesh, std::vector<Vec3d>& normals_of, std::vector<std::uint32_t>& tags,
                             double distance);

}  // namespace kerf::internal
