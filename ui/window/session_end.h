// How a workbench is left: what was cut is written.
#pragma once

#include "geometry/base/error.h"
#include "ui/app/workbench.h"
#include "ui/window/live_view.h"

namespace kerf {

/// From here on SIGTERM, SIGINT and SIGHUP end the program in good order: what was cut is written first.
void endWhenTold();
/// The signal that came; 0: none.
int toldToEnd();

/// What was cut or is being exported is written; what is being opened is cancelled. Waits for both.
/// @return  the first error of that.
Expected<void> endAll(Workbench& bench, LiveView& view);

}  // namespace kerf
