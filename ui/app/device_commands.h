// Commands about devices that are plugged in: what a SpaceMouse leads, and how; each is kept at once.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf::device_commands {

Expected<void> leads(AppContext& c, AppWords words);     ///< [tool|view|nothing]
Expected<void> gain(AppContext& c, AppWords words);      ///< FACTOR
Expected<void> deadBand(AppContext& c, AppWords words);  ///< PERCENT
Expected<void> dominant(AppContext& c, AppWords words);  ///< [on|off]
Expected<void> invert(AppContext& c, AppWords words);    ///< AXIS... or none

}  // namespace kerf::device_commands
