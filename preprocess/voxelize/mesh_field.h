// Closed mesh -> narrow-band signed distance field, by OpenVDB's meshToVolume.
#pragma once

#include <openvdb/openvdb.h>

#include "geometry/mesh/mesh.h"
#include "preprocess/voxelize/interrupter.h"

namespace kerf::internal {

/// Bands in voxels: outside the field is +exterior voxels, deep inside -interior voxels.
struct Bands {
  float exterior = 3, interior = 4;
};

/// Distance to the solid, mm, negative inside, cavities included: builds each nesting level separately, since the
/// library fills voids that its flood fill can not reach. Null when cancelled. Throws the exceptions of OpenVDB.
/// @pre mesh closed, oriented, free of self-intersections; mm.
openvdb::FloatGrid::Ptr meshField(const Mesh& solid, double voxel_mm, const Bands& bands, Interrupter& interrupter);

/// The library's call alone on all triangles, for the benchmark's ratio.
openvdb::FloatGrid::Ptr bareMeshField(const Mesh& solid, double voxel_mm, const Bands& bands, Interrupter& interrupter);

}  // namespace kerf::internal
