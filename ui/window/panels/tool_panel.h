// The tool rack with pictures, names and a search; and the hand's settings: push, depth, spray.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "ui/app/commands/app_commands.h"
#include "ui/app/tool/tool_icon.h"

namespace kerf {

/// State of the rack between two frames.
struct ToolPanelState {
  std::array<char, 64> search{};
  bool shows_all = false;
  std::size_t in_hand = 0;                                 ///< in the last frame: scrolls to a new one
  std::map<const void*, std::vector<IconTriangle>> icons;  ///< by the tool's shape
};

void drawTools(AppContext& context, ToolPanelState& state);

}  // namespace kerf
