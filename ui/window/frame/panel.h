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
#include "ui/window/frame/panel_column.h"

namespace kerf {

struct PanelState;

/// Arguments of a panel in one frame.
struct PanelFrame {
  AppContext& context;
  PanelState& state;                           ///< of the panels, between two frames
  const std::optional<ToolOverSurface>& over;  ///< the tool under the cursor
  PanelColumn& column;                         ///< at the right
};

/// The state of the window that a panel belongs to.
enum class Screen {
  kAny,
  kFirst,   ///< nothing is open
  kImport,  ///< a scan before it is prepared
  kCut,
  kReplay
};

enum class PanelPlace {
  kOwn,      ///< places itself, and draws its own window
  kColumn,   ///< a window in the column at the right: draws the content
  kReadings  ///< a folding section of the readings, open while its switch is on: draws the content
};

struct Panel {
  std::string_view id;     ///< "plots": key of AppContext::panels
  std::string_view title;  ///< in English; empty with kOwn
  Screen screen;
  PanelPlace place;
  void (*draw)(PanelFrame&);
};

/// In the order of drawing.
std::span<const Panel> panelRows();

}  // namespace kerf
