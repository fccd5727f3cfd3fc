// Intersection of a planned cut with the surface as it is now.
#pragma once

#include <array>
#include <vector>

#include "ui/app/saw/saw_plan.h"
#include "ui/app/view/live_scene.h"

namespace kerf {

/// Straight segments of the surface's contour within the plane's rectangle; world frame, unordered.
/// @cost  as LiveScene::contour(): a ms for a jaw.
std::vector<std::array<Vec3d, 2>> contourOf(const SawPlane& plane, const LiveScene& scene);

}  // namespace kerf
