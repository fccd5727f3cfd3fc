// Commands of saw planning; their rows are in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::saw_commands {

bool hasPlane(const AppContext& c);   ///< an object is open, and a plane chosen
bool isCutting(const AppContext& c);  ///< a plane is being sawn
bool isPicking(const AppContext& c);  ///< points or a line are being picked

Expected<void> fromPoints(AppContext& c, AppWords words);
Expected<void> line(AppContext& c, AppWords words);
Expected<void> fromView(AppContext& c, AppWords words);
Expected<void> fromFace(AppContext& c, AppWords words);
Expected<void> fromNumbers(AppContext& c, AppWords words);
Expected<void> pickPoints(AppContext& c, AppWords words);
Expected<void> pickLine(AppContext& c, AppWords words);
Expected<void> pickFace(AppContext& c, AppWords words);
Expected<void> pickNothing(AppContext& c, AppWords words);
Expected<void> choose(AppContext& c, AppWords words);
Expected<void> rename(AppContext& c, AppWords words);
Expected<void> remove(AppContext& c, AppWords words);
Expected<void> move(AppContext& c, AppWords words);
Expected<void> turn(AppContext& c, AppWords words);
Expected<void> tilt(AppContext& c, AppWords words);
Expected<void> approach(AppContext& c, AppWords words);
Expected<void> width(AppContext& c, AppWords words);
Expected<void> depth(AppContext& c, AppWords words);
Expected<void> fit(AppContext& c, AppWords words);
Expected<void> save(AppContext& c, AppWords words);
Expected<void> load(AppContext& c, AppWords words);
Expected<void> cut(AppContext& c, AppWords words);
Expected<void> stop(AppContext& c, AppWords words);
Expected<void> guide(AppContext& c, AppWords words);

}  // namespace kerf::saw_commands
