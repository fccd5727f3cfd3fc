// Undo, redo, timeline and branch commands; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::edit_commands {

Expected<void> undo(AppContext& context, AppWords words);
Expected<void> redo(AppContext& context, AppWords words);

// Along the timeline.

Expected<void> go(AppContext& context, AppWords words);  ///< STEP
Expected<void> begin(AppContext& context, AppWords words);
Expected<void> end(AppContext& context, AppWords words);

// Branches.

bool hasBranches(const AppContext& context);
Expected<void> branch(AppContext& context, AppWords words);  ///< [N]

}  // namespace kerf::edit_commands
