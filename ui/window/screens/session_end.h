// Ends a workbench in good order: writes the cut first.
#pragma once

#include "geometry/base/error.h"
#include "ui/app/workbench/workbench.h"
#include "ui/window/draw/live_view.h"

namespace kerf {

/// From here on SIGTERM, SIGINT and SIGHUP end the program in good order: the cut is written first.
void endWhenTold();
/// The received signal; 0: none.
int toldToEnd();

/// Writes the cut and the running export; cancels an opening. Waits for both.
/// @return  their first error.
Expected<void> endAll(Workbench& bench, LiveView& view);

}  // namespace kerf
