// The settings window.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Draws it while context.panels["settings"]. Changes apply at once and are saved when the user releases the mouse.
void drawSettings(AppContext& context);

}  // namespace kerf
