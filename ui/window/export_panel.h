// The panel in which an export is decided: what, format, where to, and what the check says before anything is written.
#pragma once

#include <functional>

#include "ui/app/app_commands.h"

namespace kerf {

/// Nothing while bench.exporting() is not shown.   @param ask_for_file  asks for a path, then runs the command with it.
void drawExportPanel(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file);

/// The keys Enter and Escape, which are the panel's while it is shown: whatever is typed, and however short the tap.
/// @return  false: it is not shown.
bool exportPanelKey(AppContext& context, bool is_enter);

}  // namespace kerf
