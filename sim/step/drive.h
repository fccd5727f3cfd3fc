// Response of a drive's speed to pedal and load.
#pragma once

#include "sim/step/tool_model.h"

namespace kerf {

/// Fraction of a drive's free speed below which it is at rest. A motor that runs down never quite stops.
inline constexpr double kAtRest = 0.02;

/// The speed a tick of kTick seconds later, by the law of ToolDrive.
/// @param speed  now, as ToolDrive::speed; negative: backwards, kGoverned alone.
/// @param pedal  -1 to 1. Only kGoverned turns backwards; for all others a negative pedal counts as released.
/// @param load  over the stall load, not negative: the mean of the tick. It slows both directions.
/// @return between -ToolDrive::speed and ToolDrive::speed; a tick never passes through standstill. @rt
double speedAfterTick(const ToolDrive& drive, double speed, double pedal, double load) noexcept;

}  // namespace kerf
