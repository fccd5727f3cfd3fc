// How the speed of a drive answers to pedal and load.
#pragma once

#include "sim/step/tool_model.h"

namespace kerf {

/// The speed a tick of kTick seconds later, by the law of ToolDrive.
/// @param speed  now, as ToolDrive::speed, not negative.   @param pedal  0 to 1.
/// @param load  over the stall load, not negative: the mean of the tick.   @return not negative. @rt
double speedAfterTick(const ToolDrive& drive, double speed, double pedal, double load) noexcept;

}  // namespace kerf
