// Normals for drawing: smooth over gentle bends, sharp over creases such as the rim of a cut.
#pragma once

#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

/// One unit normal per corner, 3 per triangle in order. A corner takes the angle-weighted mean of the triangles around
/// its vertex that bend from its own triangle by less than `crease` (rad, 0 = flat shading, pi = smooth everywhere).
/// A triangle without area takes the mean of all its neighbours'; without neighbours +z.
/// O(sum of squared valences), where triangles without area do not count.
std::vector<Vec3f> cornerNormals(const Mesh& mesh, double crease);

}  // namespace kerf
