// Plots of the last 20 s, a folding part of the readings panel.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Draws within the panel's window.
void drawPlots(AppContext& context);

}  // namespace kerf
