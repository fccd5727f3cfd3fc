// Surface of an implicit solid by marching tetrahedra: for our own demo shapes, where the function is cheap.
#pragma once

#include <functional>

#include "geometry/mesh.h"

namespace kerf::internal {

/// Surface of {value < 0} inside `box`, outward-oriented, mm. The box is filled with a body-centred cubic lattice of
/// cubes `spacing` mm wide, cut into congruent tetrahedra, four around each edge of the cubes. In each tetrahedron the
/// surface is one flat triangle or two with a common edge, strictly inside the edges it crosses, so it is closed,
/// 2-manifold and free of self-intersections, whatever the function. Vertices are placed by `refinements` secant steps
/// on the function along the lattice edge. Order depends on the input only.
/// @pre value > 0 on the boundary of the box and half a spacing beyond (else the mesh is open there).
/// @cost one call per lattice node, 2 (size / spacing)^3 of them, and `refinements` per vertex.
Mesh meshImplicit(const std::function<double(const Vec3d&)>& value, const Box3& box, double spacing,
                  int refinements = 3);

/// Evens out the triangles of a surface that meshImplicit made of `value`: each round moves every vertex to the mean of
/// its neighbours and back onto the surface along the gradient. A move that would turn a triangle by more than 60 deg
/// is left out, so no triangle folds over; keep the sides of a narrow slot wider apart than an edge.
void evenOut(Mesh& mesh, const std::function<double(const Vec3d&)>& value, int rounds);

}  // namespace kerf::internal
