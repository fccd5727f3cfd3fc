// The running job: its step, progress, time left, and Cancel.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Draws nothing without a job, and for a job that the export panel shows.
void drawJob(AppContext& context);

}  // namespace kerf
