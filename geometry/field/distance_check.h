// Checks that the numbers of a grid can be distances.
#pragma once

#include <string>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"

namespace kerf {

/// Rejects a field of an object whose numbers are no signed distances: noise (neighbours a voxel apart differ by more
/// than the voxel's size in more than a hundredth of all pairs), or of the wrong sign (inside where nothing lies
/// beside). Distances change by a voxel's size at most from node to node; a small tolerance allows for rounding and
/// resampling.
/// @param phi  whole: the field as baked, not the bricks of a cut.
/// Error kBadValue with the share and the first place; never throws.
/// @cost  linear: 1 us a brick.
Expected<void> requireDistances(const BrickField& phi);

/// The same for the bricks of a part of an object, such as a fine region: checks noise only. Their neighbours are
/// unknown, so requireSameSides() checks the sign.
/// @param grid  its name, for the message.   Error, cost: as above.
Expected<void> requireDistancesInPart(const BrickField& part, const std::string& grid);

/// The same for the bricks that a cut changed. Between tissues of different resistance a valid field has steps: rejects
/// the cut only if more than a fifth of all pairs are steps.
Expected<void> requireDistancesOfCut(const BrickField& cut, const std::string& grid);

/// Rejects a cut that adds material: cutting never makes a distance smaller. The tolerance for rounding is a hundredth
/// of a voxel.
/// @param before  the whole field before the cut, on the same voxels.
/// @param begin  bricks with more material than `before` at the start, such as a filling; null: none.
/// Error kBadValue with the largest excess depth, and the first place.   @cost  linear: 1 us a brick.
Expected<void> requireOnlyTaken(const BrickField& cut, const BrickField& before, const BrickField* begin,
                                const std::string& grid);

/// Rejects a part whose sign differs from the whole in more than a hundredth of the tested places, farther than a voxel
/// of the whole from its surface.
/// @param whole  the field of the same object, on any voxels.
/// @cost linear: about 5 us a brick of the part, with 8 tested places.
Expected<void> requireSameSides(const BrickField& part, const BrickField& whole, const std::string& grid);

}  // namespace kerf
