// The settings window.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Draws it while context.shows_settings. Changes apply at once and are saved when the user releases the mouse.
void drawSettings(AppContext& context);

}  // namespace kerf
