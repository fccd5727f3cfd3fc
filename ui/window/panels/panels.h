// Menus and panels around the picture. They show a workbench and run commands; they hold no other state.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "ui/app/commands/app_commands.h"
#include "ui/app/tool/stroke.h"
#include "ui/window/frame/notices.h"
#include "ui/window/frame/panel.h"
#include "ui/window/panels/device_panel.h"
#include "ui/window/panels/drill_panel.h"
#include "ui/window/panels/import_panel.h"
#include "ui/window/panels/pieces_panel.h"
#include "ui/window/panels/saw_panel.h"
#include "ui/window/panels/sessions_panel.h"
#include "ui/window/panels/tool_panel.h"
#include "ui/window/screens/first_screen.h"

namespace kerf {

/// State of the panels between two frames.
struct PanelState {
  /// For commands whose parameter is a path: asks for a file first. Set by the window.
  std::function<void(const AppCommand&)> ask_for_file;
  NoticesState notices;
  std::size_t tour_step = 0;
  std::optional<std::array<double, 2>> menu_at{};  ///< pixel of the picture: opens the context menu there
  ToolPanelState tools{};
  PieceDrag piece_drag{};
  double pixels = 1;  ///< of the picture per window unit
  ImportPanelState import;
  FirstScreen first;
  SessionsPanelState sessions;
  SawPanelState saw{};
  DrillPanelState drill{};
  DevicePanelState devices{};
};

/// Menu bar, tools, readings, job, notices; the first screen while no document is open.
/// @param rows  of the table of panels; others in tests.
void drawPanels(AppContext& context, PanelState& state, const std::optional<ToolOverSurface>& over,
                std::span<const Panel> rows = panelRows());

}  // namespace kerf
