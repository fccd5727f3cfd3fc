// Whether the numbers of a grid can be distances at all.
#pragma once

#include <string>

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

/// The same for the bricks of a part of an object, such as those of a fine region: noise alone. What lies beside them
/// is not known, so that a turned sign is not seen: requireSameSides() sees it.
/// @param grid  its name, for the message.   Error, cost: as above.
Expected<void> requireDistancesInPart(const BrickField& part, const std::string& grid);

/// The same for the bricks that a cut changed. Where one tissue gives way sooner than the one beside it, an honest
/// field has steps: it is refused only if more than a fifth of all pairs are such.
Expected<void> requireDistancesOfCut(const BrickField& cut, const std::string& grid);

/// Refuses a cut with material where there was none before: cutting never makes a distance smaller. A hundredth of a
/// voxel is let for rounding.
/// @param before  the field that was cut, whole, on the same voxels.
/// @param begin  bricks in which there was more than in `before` already, as a filling; null: none.
/// Error kBadValue with how much deeper it lies at most, and where first.   @cost  linear: 1 us a brick.
Expected<void> requireOnlyTaken(const BrickField& cut, const BrickField& before, const BrickField* begin,
                                const std::string& grid);

/// Refuses a part that is inside where the whole is outside, or the other way round, in more than a hundredth of the
/// places asked, farther than a voxel of the whole from its surface.
/// @param whole  the field of the same object, on any voxels.
/// @cost linear: about 5 us a brick of the part, which is asked in 8 places.
Expected<void> requireSameSides(const BrickField& part, const BrickField& whole, const std::string& grid);

}  // namespace kerf
