// Distance field -> point shell: the surface nodes with inward normal, area weight, and material.
#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <functional>

#include "preprocess/voxelize/interrupter.h"

namespace kerf::internal {

struct PointShell {
  openvdb::GridBase::Ptr grid;  ///< a points::PointDataGrid
  std::uint64_t points = 0;
  double area_mm2 = 0;    ///< sum of the area weights
  double volume_mm3 = 0;  ///< volume of {phi < 0} in those bricks
};

/// One point per node |phi| < 1.5 voxels, exactly on the node: its position in the voxel is zero everywhere and costs
/// no memory. Attributes: N (inward, unit), area (mm^2, delta_e(phi) |grad phi| h^3), material.
/// @param material  labels of at least all these nodes.   @param keep  true for the bricks to use, by their first node.
/// Parallel; the sums do not depend on threads.
PointShell makePointShell(const openvdb::FloatGrid& phi, const openvdb::Int32Grid& material,
                          const std::function<bool(const openvdb::Coord&)>& keep, Interrupter& interrupter);

}  // namespace kerf::internal
