// The command palette: a line, and the commands that have its words.
#pragma once

#include "ui/app/command_palette.h"

namespace kerf {

/// Draws it while it is shown.   @return as CommandPalette::accept(), after a click on a row.
const AppCommand* drawPalette(AppContext& context, CommandPalette& palette);

}  // namespace kerf
