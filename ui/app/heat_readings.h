// The temperatures that are shown of a cut, and from which limit on each is a warning.
#pragma once

#include "geometry/field/material.h"
#include "sim/live/live_heat.h"

namespace kerf {

struct HeatReading {
  double celsius = kBodyCelsius;
  bool is_warning = false;  ///< at its limit or above
};

/// Of the tissue under the tool. Limits: bone that dies after a minute; of all else a surface that boils.
HeatReading heatOfSurface(const HeatReport& heat, Material under);
/// Of what must be kept, a pulp or a nerve canal. Limits: a pulp that does not always recover; the bone around a nerve.
HeatReading heatOfKept(const HeatReport& heat, Material kept);

}  // namespace kerf
