// The numbers of the session that has just ended, and the way back to it.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Over the first screen, until it is closed or another document opens.
void drawDebrief(AppContext& context);
/// Esc.   @return  false: it is not shown.
bool closeDebrief(AppContext& context);

}  // namespace kerf
