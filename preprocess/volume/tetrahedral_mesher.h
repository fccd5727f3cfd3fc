// Surface of an implicit solid by marching tetrahedra: for Kerf's demo shapes, with a cheap function.
#pragma once

#include <functional>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf::internal {

/// An implicit solid: negative inside, mm or nearly so. Pure: called from many threads at once.
using Implicit = std::function<double(const Vec3d&)>;

/// Surface of {value < 0} inside `box`, outward-oriented, mm. The box is filled with a body-centred cubic lattice of
/// cubes `spacing` mm wide, cut into congruent tetrahedra, four around each edge of the cubes. In each tetrahedron the
/// surface is one flat triangle or two with a common edge, strictly inside the edges it crosses, so it is closed,
/// 2-manifold and free of self-intersections, for any function. Vertices are placed by `refinements` secant steps on
/// the function along the lattice edge. Order depends on the input only. Triangles have a mean edge of about
/// kEdgeToSpacing times the spacing.
/// @param steepness  0, or a bound on |value(p) - value(q)| / |p - q| over the box. Skips blocks of cubes that by
///                   the bound hold no surface; too small a bound loses parts of the surface.
/// @pre value > 0 on the boundary of the box and half a spacing beyond (else the mesh is open there).
/// @cost one call per lattice node of the blocks that are not skipped, 2 (size / spacing)^3 of them without
///       `steepness`, and `refinements` per vertex; parallel.
Mesh meshImplicit(const Implicit& value, const Box3& box, double spacing, int refinements = 3, double steepness = 0);
inline constexpr double kEdgeToSpacing = 0.448;

/// Evens out the triangles of a surface from meshImplicit() of `value`: each round moves every vertex to the mean of
/// its neighbours and back onto the surface along the gradient. Skips moves that would turn a triangle by more than 60
/// deg, so no triangle folds over. If the sides of a slot narrower than an edge would cross (as float32), their
/// vertices move back: no self-intersection is added.
/// Visits vertices in the order of their numbers, in parallel where the result is the same.
void evenOut(Mesh& mesh, const Implicit& value, int rounds);

/// Puts vertices back to `old`, no more than needed, until as float32 no two triangles cross and none is degenerate.
/// @pre `old` satisfies this, and old.size() == mesh.vertices.size().
void undoCrossings(Mesh& mesh, const std::vector<Vec3d>& old);

}  // namespace kerf::internal
