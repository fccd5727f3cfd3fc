// Quitting: asks once about a cut that was not exported. No work is lost: sessions are kept.
#pragma once

#include <string>

#include "ui/app/commands/app_commands.h"

namespace kerf::quit {

/// Ends the program, or asks first: AppContext::is_asking_to_quit. A second call while it asks confirms.
Expected<void> quit(AppContext& c, AppWords words);
bool isAsking(const AppContext& c);
/// The window stays open.
Expected<void> stay(AppContext& c, AppWords words);
/// Keeps the window open, with the export panel if available.
void exportFirst(AppContext& c);

/// "Your cut is kept in ...; it was not exported."
std::string question(const Workbench& bench);

}  // namespace kerf::quit
