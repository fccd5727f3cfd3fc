// Volumes that tools remove from a half-space in a straight plunge, from their outlines: parts of plungeVolume().
#pragma once

#include <vector>

#include "geometry/tool/tool_shape.h"

namespace kerf::internal {

/// Along its axis, `depth` mm from the lowest point on: pi times the integral of R(z)^2, R the widest radius so far.
/// mm^3. @pre `head` is closed.
double revolvedPlunge(const RevolvedProfile& head, double depth);
/// Sideways, `depth` mm from the widest radius inwards: the integral of the segments that its circles cut. mm^3.
double sidewaysPlunge(const RevolvedProfile& head, double depth);
/// Along its axis for an outline with hollows, which leave a core; good to 1e-3 of itself. mm^3.
double turnedPlunge(const RevolvedProfile& outline, const std::vector<RevolvedProfile>& hollows, double depth);

/// Area that a circle of radius r cuts out of a half-plane `offset` away from its centre, pushed in along the normal: 2
/// x integral over 0 <= x <= limit of max(0, sqrt(r^2 - x^2) - offset). mm^2.
double pushedCircle(double r, double offset, double limit);

}  // namespace kerf::internal
