// Union of solids by their distance fields, for parts that almost touch and have no exact union.
#pragma once

#include <span>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct VoxelUnion {
  Mesh mesh;              ///< closed, 2-manifold, outward, mm
  double rms_off_mm = 0;  ///< distance of its vertices from the surface of the parts
  double largest_off_mm = 0;
};

/// Offsets the union of the parts outwards by one voxel and back (a morphological closing): sheets of air up to two
/// voxels thick between parts vanish, the rest moves by less than a fraction of a voxel. Rounds concave edges sharper
/// than the voxel. Meshes by marching cubes.
/// @pre every solid closed, oriented, free of self-intersections, mm.
/// Deterministic; parallel inside. @cost three distance fields.
Expected<VoxelUnion> voxelUnion(std::span<const Mesh> solids, double voxel_mm, const Progress& progress = {});

}  // namespace kerf
