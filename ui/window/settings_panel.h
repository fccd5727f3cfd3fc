// The settings window.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf {

/// Draws it while context.shows_settings. What is changed holds at once and is kept when the mouse lets go.
void drawSettings(AppContext& context);

}  // namespace kerf
