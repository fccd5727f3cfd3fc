// Commands about neighbours of the object in work; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::neighbour_commands {

bool hasNeighbours(const AppContext& context);
bool hasNeighboursAndIdle(const AppContext& context);

Expected<void> openBeside(AppContext& context, AppWords words);    ///< PATH
Expected<void> workOn(AppContext& context, AppWords words);        ///< [NEIGHBOUR]
Expected<void> look(AppContext& context, AppWords words);          ///< NEIGHBOUR show|ghost|hide
Expected<void> stopShort(AppContext& context, AppWords words);     ///< [MM|off]
Expected<void> exportBeside(AppContext& context, AppWords words);  ///< PATH [NEIGHBOUR]

}  // namespace kerf::neighbour_commands
