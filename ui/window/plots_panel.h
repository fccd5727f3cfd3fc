// Plots of the last 20 s, a part of the panel of readings that folds.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf {

/// Within the panel's window.
void drawPlots(AppContext& context);

}  // namespace kerf
