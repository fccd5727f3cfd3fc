// Whether the numbers of a grid can be distances at all.
#pragma once

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"

namespace kerf {

/// Refuses a field of an object whose numbers are no signed distances: noise (neighbours a voxel apart differ by more
/// than the voxel's size in more than a hundredth of all pairs), or of the wrong sign (inside where nothing lies
/// beside). Distances change by a voxel's size at most from node to node; a little is let for rounding and for what
/// was resampled.
/// @param phi  whole: the field as baked, not the bricks of a cut.
/// Error kBadValue with the share and where the first is; never throws.
/// @cost  linear: 1 us a brick.
Expected<void> requireDistances(const BrickField& phi);

}  // namespace kerf
