// The colour ramp of every map of a number over a surface.
#pragma once

#include "geometry/base/types.h"

namespace kerf {

/// Map colour: light yellow to dark blue, evenly darker, distinct for colour-blind users.
/// @param share  0 light to 1 dark; clamped; not finite: dark.
Rgba8 mapColour(double share);

}  // namespace kerf
