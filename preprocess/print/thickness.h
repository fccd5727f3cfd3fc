// Wall thickness of a solid at each vertex.
#pragma once

#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct ThicknessOptions {
  double most_mm = 10;  ///< thicker places get this value; the cost grows with it
  /// Two surfaces form a wall if their normals are opposite within this angle, 5 to 85. Larger: the edges of a block
  /// count as thin, since their faces meet there. Smaller: thin wedges are missed.
  double opposing_deg = 60;
};

/// Diameter of the largest ball inside that touches the surface at the vertex and cuts no opposing surface, mm: the
/// shrinking ball of Ma, Bae & Choi (The Visual Computer 28, 2012) against triangles in place of sample points. Chosen
/// over a mean of rays in a cone (Shapiro, Shamir & Cohen-Or 2008), which is longer than the wall and depends on the
/// number of rays. At a crease the least over its faces. 0 at a knife edge: one fold of a scan has it, so judge a wall
/// by the area below a limit, see surfaceNumbers(). Exact to 0.01 % on plates, tubes, hollow balls and wedges, up to
/// the normals: a vertex normal off by a gives a plate too thick by a^2 / 4.
/// @param solid  closed, outward. Of an open surface only walls with both sides have a thickness.
/// Fails with kEmpty, kGeometry (inside out), kBadValue, kCancelled. Deterministic; parallel inside.
/// @cost  sixteen crowns, 84 000 triangles: 1.2 s of one core, 0.3 s with most_mm = 3; 20 MB.
Expected<std::vector<double>> wallThickness(const Mesh& solid, const ThicknessOptions& options = {},
                                            const Progress& progress = {});

}  // namespace kerf
