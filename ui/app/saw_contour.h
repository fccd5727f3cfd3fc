// Where a planned cut meets the surface as it is now.
#pragma once

#include <array>
#include <vector>

#include "ui/app/live_scene.h"
#include "ui/app/saw_plan.h"

namespace kerf {

/// Straight pieces of the surface's contour in a plane, of those within its rectangle; world frame, in no order.
/// @cost  as LiveScene::contour(): a ms for a jaw.
std::vector<std::array<Vec3d, 2>> contourOf(const SawPlane& plane, const LiveScene& scene);

}  // namespace kerf
