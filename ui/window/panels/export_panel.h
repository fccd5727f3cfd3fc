// The export panel: pieces, format, path, and the result of the check before Kerf writes.
#pragma once

#include <functional>

#include "ui/app/commands/app_commands.h"
#include "ui/app/workbench/export_plan.h"

namespace kerf {

/// Draws nothing unless *bench.exporting is shown.   @param ask_for_file  asks for a path, then runs the command with
/// it.
void drawExportPanel(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file);

/// The panel's keys Enter and Escape: they work during text input, and however short the tap.
/// @return  false: the panel is hidden.
bool exportPanelKey(AppContext& context, bool is_enter);

}  // namespace kerf
