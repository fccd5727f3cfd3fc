// A panel: a row of the table in panels.cpp.
//
// A new panel is two files with a function draw...(PanelFrame&), and one row. A panel that the user shows and hides has
// a command with switchPanel<"ID"> (ui/app/commands/command_tables.h).
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "ui/app/commands/app_commands.h"
#include "ui/app/tool/stroke.h"
#include "ui/window/frame/frame_layout.h"

namespace kerf {

struct PanelState;

/// Arguments of a panel in one frame.
struct PanelFrame {
  AppContext& context;
  PanelState& state;                           ///< of the panels, between two frames
  const std::optional<ToolOverSurface>& over;  ///< the tool under the cursor
};

enum class PanelPlace {
  kOwn,         ///< places itself, and draws its own window
  kLeft,        ///< a section of the left column: draws the content
  kRight,       ///< the same, of the right column
  kFoldedRight  ///< the same, folded until its switch is on
};

struct Panel {
  std::string_view id;     ///< "plots": key of AppContext::panels
  std::string_view title;  ///< in English; empty with kOwn
  Screen screen;
  PanelPlace place;
  void (*draw)(PanelFrame&);
  bool (*is_needed)(const AppContext&) = nullptr;  ///< false: the column leaves the section out; null: always there
};

/// In the order of drawing.
std::span<const Panel> panelRows();

}  // namespace kerf
