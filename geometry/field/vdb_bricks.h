// OpenVDB grids in memory <-> brick fields.
#pragma once

#include <openvdb/openvdb.h>

#include "geometry/field/brick_field.h"

namespace kerf::internal {

/// Leaf nodes become bricks; tiles below zero mark interior bricks.
/// @pre a plain uniform scale, within coordKey()'s range.
BrickField toBricks(const openvdb::FloatGrid& grid);

}  // namespace kerf::internal
