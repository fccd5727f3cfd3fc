// Gives a scan without underside a flat base: walls straight down from its rims, and a cap.
#pragma once

#include "preprocess/internal/chain.h"

namespace kerf::internal {

/// Adds walls from the rims to the plane {x[axis] = level} and the part of the plane they enclose, so that the rims are
/// no longer boundary. Rims that cross themselves in projection are allowed: the crossings become vertices (rounded to
/// float32 in the plane, repeated until nothing crosses), and a face the rims wind around k times is added |k| times.
/// @param level  a float32 number beyond all vertices.  @param outward  +1 or -1: the side of the plane that is
/// outside.
/// @return false if the projection could not be triangulated; the chain is then unchanged.
bool extrudeToBase(Chain& chain, const std::vector<Loop>& rims, int axis, int outward, double level);

}  // namespace kerf::internal
