// Help for the commands of the window, from their table, and for scripts.
#pragma once

#include <vector>

#include "ui/app/program/help_page.h"

namespace kerf {

/// Pages "window", all commands by menu, and "script", the language of `kerf-sim --script`.
std::vector<HelpPage> windowHelp();

}  // namespace kerf
