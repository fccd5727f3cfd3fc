// The main menu: the headings, and a row for each command that names one.
#pragma once

#include <functional>

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// @param ask_for_file  asks for a path, then runs the command with it.
void drawMainMenu(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file);

}  // namespace kerf
