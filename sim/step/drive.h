// How the speed of a drive answers to pedal and load.
#pragma once

#include "sim/step/tool_model.h"

namespace kerf {

/// Of a drive's free speed: what turns more slowly is at rest. A motor that runs down is never quite so.
inline constexpr double kAtRest = 0.02;

/// The speed a tick of kTick seconds later, by the law of ToolDrive.
/// @param speed  now, as ToolDrive::speed; negative: backwards, kGoverned alone.
/// @param pedal  -1 to 1. Only kGoverned turns backwards: for all others a negative pedal is one that is up.
/// @param load  over the stall load, not negative: the mean of the tick. It slows either way of turning.
/// @return between -ToolDrive::speed and that; a tick never passes through standstill. @rt
double speedAfterTick(const ToolDrive& drive, double speed, double pedal, double load) noexcept;

}  // namespace kerf
