// The list of tissues with colours and visibility, and the legend of a map of depth or distance.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// More than one tissue, or a map is shown.
bool areTissuesNeeded(const AppContext& context);
void drawTissues(AppContext& context);

}  // namespace kerf
