// What is drawn about a scan while it is imported, to tell what was found.
#pragma once

#include <array>

#include "geometry/base/types.h"

namespace kerf {

/// Corners of a rectangle of the plane, one after the other around it: as wide as the box is, seen along the normal,
/// and about the middle of the box.   @param plane  its normal may have any length.
std::array<Vec3d, 4> rectangleOf(const Plane& plane, const Box3& box);

}  // namespace kerf
