// Quitting: a cut that was not exported is asked about, once. It is no question of losing work: sessions are kept.
#pragma once

#include <string>

#include "ui/app/app_commands.h"

namespace kerf::quit {

/// Ends the program, or asks first: AppContext::is_asking_to_quit. A second time while it asks is an answer.
Expected<void> quit(AppContext& c, AppWords words);
bool isAsking(const AppContext& c);
/// The window stays open.
Expected<void> stay(AppContext& c, AppWords words);
/// The window stays open, with the export panel where that can be shown.
void exportFirst(AppContext& c);

/// "Your cut is kept in ...; it was not exported."
std::string question(const Workbench& bench);

}  // namespace kerf::quit
