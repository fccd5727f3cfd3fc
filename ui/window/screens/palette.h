// The command palette: an input line, and the commands that match its words.
#pragma once

#include "ui/app/script/command_palette.h"

namespace kerf {

/// Draws the palette while shown.   @return like CommandPalette::accept(), after a click on a row.
const AppCommand* drawPalette(AppContext& context, CommandPalette& palette);

}  // namespace kerf
