// Displayed temperatures of a cut, with their warning limits.
#pragma once

#include "geometry/field/material.h"
#include "sim/live/live_heat.h"

namespace kerf {

struct HeatReading {
  double celsius = kBodyCelsius;
  bool is_warning = false;  ///< at or above its limit
};

/// Tissue under the tool. Limits: bone: necrosis after a minute; other tissue: boiling at the surface.
HeatReading heatOfSurface(const HeatReport& heat, Material under);
/// A pulp or nerve canal. Limits: pulp: recovery uncertain; nerve canal: the limit of the bone around it.
HeatReading heatOfKept(const HeatReport& heat, Material kept);

}  // namespace kerf
