// Marching cubes on a sparse field: a closed, 2-manifold triangle mesh of the zero set.
//
// After Lorensen & Cline, SIGGRAPH 1987, with a generated table that is consistent on shared faces: on an ambiguous
// face the negative corners stay separate, seen from either side. Hence no holes and no edge with other than two
// triangles, as long as every sign change lies between stored nodes. Loops of six and more corners are closed by a fan
// about their centroid, shorter ones by a fan about their first corner.
#pragma once

#include "geometry/brick_field.h"
#include "geometry/mesh.h"

namespace kerf {

struct MarchingCubesOptions {
  /// Values nearer to zero than this many voxels are moved away from it (keeping their sign; zero counts as positive),
  /// so that no vertex lands on a node and no triangle collapses. 0.02 costs at most 0.02 voxels of accuracy.
  double snap_voxels = 0.02;
  /// Subtracts this times the field's discrete Laplacian (h^2 times twice the mean curvature) before meshing, 0 = off.
  /// Triangles are chords of the surface and linear interpolation moves their corners further in: a plain mesh of a
  /// ball of radius r is short by about 0.5 (h/r)^2 of its volume. The default places the mesh as much outside as
  /// inside. Flat walls do not notice; too large a value (> 0.16) makes the field oscillate.
  float chord_balance = 0.1f;
};

/// Surface of {field < 0}, outward-oriented, mm. Vertices and triangles come in an order that depends on the field
/// only. O(stored bricks); parallel inside.
Mesh marchingCubes(const BrickField& field, const MarchingCubesOptions& options = {});

}  // namespace kerf
