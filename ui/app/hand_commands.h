// Commands for how the tool is held and led; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf::hand_commands {

bool isTilted(const AppContext& context);

Expected<void> tilt(AppContext& context, AppWords words);  ///< DEG [AZIMUTH]
Expected<void> resetTilt(AppContext& context, AppWords words);

}  // namespace kerf::hand_commands
