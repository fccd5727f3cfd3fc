// The menu bar with its tools, and the menu at the cursor.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Rows of the command tables, and a few of them as icons at the right end.
void drawMainMenu(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file);

/// Commands at a place of the picture.   @param at  opens it there once, and is reset; pixels.
void drawContextMenu(AppContext& context, std::optional<std::array<double, 2>>& at);

}  // namespace kerf
