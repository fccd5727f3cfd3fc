// Distance field + claims -> the material of every node.
#pragma once

#include <openvdb/openvdb.h>

#include <span>
#include <vector>

#include "preprocess/voxelize/interrupter.h"
#include "preprocess/voxelize/voxelize.h"

namespace kerf::internal {

/// Labels of all nodes phi < 1.5 voxels (the inside and the whole point shell): the first claim that covers a node
/// wins. Nodes that no claim covers take the nearest label within kFillNodes, voxel by voxel, and `options.material`
/// beyond. Uniform regions are tiles. Null when cancelled.
/// @param volumes  volumes that each claim covers and gets, and volume without a claim; mm^3.
openvdb::Int32Grid::Ptr paintMaterials(const Mesh& solid, const openvdb::FloatGrid& phi, const VoxelizeOptions& options,
                                       std::span<const MaterialClaim> claims, MaterialVolumes& volumes,
                                       Interrupter& interrupter);

}  // namespace kerf::internal
