// Guides drawn about a scan during import.
#pragma once

#include <array>

#include "geometry/base/types.h"

namespace kerf {

/// Corners of a rectangle in the plane, in order around it. It covers the box seen along the normal, centred on the
/// box.   @param plane  its normal may have any length.
std::array<Vec3d, 4> rectangleOf(const Plane& plane, const Box3& box);

}  // namespace kerf
