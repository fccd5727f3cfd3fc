// What a planned cut leaves to pulp and nerve canal, before it is sawn.
#pragma once

#include "sim/monitor/structures.h"
#include "ui/app/saw_plan.h"

namespace kerf {

/// How near the kerf of a plane comes to what must be kept, as loaded.
struct SawClearance {
  Material material = Material::kNone;
  double distance_mm = 0;  ///< between kerf and structure; negative: the plane goes through it
  bool is_far = true;      ///< farther than is measured: distance_mm is the reach
};

/// Over the whole rectangle, 0.25 mm from point to point, which adds up to 0.05 mm.
/// @param kerf_mm  width of the cut.   @pre structures are not empty.   @cost  10 ms for a plane through a jaw.
SawClearance clearanceOf(const SawPlane& plane, double kerf_mm, const Structures& structures);

}  // namespace kerf
