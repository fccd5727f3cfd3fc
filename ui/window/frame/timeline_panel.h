// The strip of steps below the picture: a block each, a mark at the current step, and jumps by mouse.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Height of the strip at the lower edge, window units; 0 without steps: no strip.
float timelineHeight(const AppContext& context);
void drawTimeline(AppContext& context);

}  // namespace kerf
