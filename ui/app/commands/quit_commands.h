// Quitting: asks once about a cut that was not exported. No work is lost: sessions are kept. The commands app.quit and
// app.stay are in quit_commands.cpp.
#pragma once

#include <string>

#include "ui/app/commands/app_commands.h"

namespace kerf::quit {

/// Keeps the window open, with the export panel if available.
void exportFirst(AppContext& c);

/// "Your cut is kept in ...; it was not exported."
std::string question(const Workbench& bench);

}  // namespace kerf::quit
