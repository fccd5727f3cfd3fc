// Commands for devices: target and mapping of a SpaceMouse, saved at once; the window's force-feedback device.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::device_commands {

Expected<void> leads(AppContext& c, AppWords words);     ///< [tool|view|nothing]
Expected<void> gain(AppContext& c, AppWords words);      ///< FACTOR
Expected<void> deadBand(AppContext& c, AppWords words);  ///< PERCENT
Expected<void> dominant(AppContext& c, AppWords words);  ///< [on|off]
Expected<void> invert(AppContext& c, AppWords words);    ///< AXIS... or none

bool isOpen(const AppContext& c);
bool isLeading(const AppContext& c);
bool isArmed(const AppContext& c);

Expected<void> open(AppContext& c, AppWords words);  ///< NAME
Expected<void> close(AppContext& c, AppWords words);
Expected<void> arm(AppContext& c, AppWords words);
Expected<void> disarm(AppContext& c, AppWords words);
Expected<void> fit(AppContext& c, AppWords words);
Expected<void> force(AppContext& c, AppWords words);    ///< NEWTONS
Expected<void> scale(AppContext& c, AppWords words);    ///< FACTOR
Expected<void> turn(AppContext& c, AppWords words);     ///< DEG
Expected<void> pedal(AppContext& c, AppWords words);    ///< [on|off]
Expected<void> profile(AppContext& c, AppWords words);  ///< MS KG NEWTONS MM
Expected<void> place(AppContext& c, AppWords words);    ///< X Y Z
Expected<void> test(AppContext& c, AppWords words);     ///< [NEWTONS [X Y Z]]
Expected<void> panel(AppContext& c, AppWords words);    ///< [on|off]

/// The device of the window as one JSON object, for scripts.
std::string deviceState(const AppContext& c);

}  // namespace kerf::device_commands
