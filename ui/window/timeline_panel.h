// The strip of steps below the picture: a block each, where now is, and going elsewhere by mouse.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf {

/// Window units that the strip takes from the lower edge; 0: there are no steps, and no strip.
float timelineHeight(const AppContext& context);
void drawTimeline(AppContext& context);

}  // namespace kerf
