// The part of the saw panel for dies: plan one, its numbers, cut it.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Runs commands; errors become notices. Drawn within the saw panel.
void drawDie(AppContext& context);

}  // namespace kerf
