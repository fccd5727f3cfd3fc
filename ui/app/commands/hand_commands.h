// Commands to tilt, move and drive the tool; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::hand_commands {

bool isTilted(const AppContext& context);

Expected<void> tilt(AppContext& context, AppWords words);  ///< DEG [AZIMUTH]
Expected<void> resetTilt(AppContext& context, AppWords words);

bool isCutting(const AppContext& context);

Expected<void> nudge(AppContext& context, AppWords words);          ///< RIGHT UP IN
Expected<void> pedal(AppContext& context, AppWords words);          ///< [on|off] [X Y]
Expected<void> reverse(AppContext& context, AppWords words);        ///< [on|off]
Expected<void> setSpeed(AppContext& context, AppWords words);       ///< PERCENT
Expected<void> setIrrigation(AppContext& context, AppWords words);  ///< PERCENT

}  // namespace kerf::hand_commands
