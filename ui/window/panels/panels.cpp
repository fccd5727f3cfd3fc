#include "ui/window/panels/panels.h"

#include <imgui.h>

#include <algorithm>
#include <initializer_list>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/view_state.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/window/frame/job_panel.h"
#include "ui/window/frame/main_menu.h"
#include "ui/window/frame/notices.h"
#include "ui/window/frame/panel.h"
#include "ui/window/frame/timeline_panel.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"
#include "ui/window/panels/export_panel.h"
#include "ui/window/panels/help_panel.h"
#include "ui/window/panels/measure_panel.h"
#include "ui/window/panels/plots_panel.h"
#include "ui/window/panels/readings_panel.h"
#include "ui/window/panels/replay_panel.h"
#include "ui/window/panels/settings_panel.h"
#include "ui/window/panels/tissues_panel.h"
#include "ui/window/screens/debrief.h"
#include "ui/window/screens/quit_question.h"
#include "ui/window/screens/scale_bar.h"

namespace kerf {
namespace {

// At the lower right of the free area.
void drawScaleBar(const AppContext& context, double pixels) {
  const FrameArea free = frameLayout(context).free;
  const auto width = static_cast<int>(pixels * static_cast<double>(free.width()));
  drawScaleBarAt({free.right - scaled(16), free.bottom - scaled(16)}, context.camera, width, context.height, pixels,
                 styleColours().guide_text);
}

// Above the scale bar, beside the tour: the object is shown as loaded. Else in the middle above the strip: the reason
// why the stroke removes nothing.
void drawLabel(const AppContext& context) {
  const TissueDisplay& tissues = context.bench.views->tissues();
  const bool is_as_loaded = tissues.isAsLoadedShown();
  const std::string text = !is_as_loaded        ? context.bench.monitor->hindranceShown()
                           : tissues.asLoaded() ? shownText("As loaded")
                                                : shownText("Preparing the object as loaded...");
  if (text.empty()) return;
  const FrameArea free = frameLayout(context).free;
  if (is_as_loaded)
    ImGui::SetNextWindowPos({free.right - scaled(8), free.bottom - scaled(44)}, ImGuiCond_Always, {1, 1});
  else
    ImGui::SetNextWindowPos({free.middle(), free.bottom - scaled(8)}, ImGuiCond_Always, {0.5f, 1});
  ui::begin("##label", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PushTextWrapPos(std::min((is_as_loaded ? 0.3f : 1) * free.width() - scaled(32), scaled(460)));
  ui::textColored(is_as_loaded ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : styleColours().warning, text);
  ImGui::PopTextWrapPos();
  ImGui::End();
}

// The table. A row below draws over those above it.
constexpr auto kOwn = PanelPlace::kOwn, kLeft = PanelPlace::kLeft, kRight = PanelPlace::kRight,
               kFolded = PanelPlace::kFoldedRight;
constexpr Panel kPanels[] = {
    {"menu", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawMainMenu(f.context, f.state.ask_for_file); }},
    {"first", "", Screen::kFirst, kOwn, [](PanelFrame& f) { f.state.first.draw(f.context, f.state.ask_for_file); }},
    {"debrief", "", Screen::kFirst, kOwn, [](PanelFrame& f) { drawDebrief(f.context); }},
    {"import", "", Screen::kImport, kOwn, [](PanelFrame& f) { drawImportPanel(f.context, f.state.import); }},
    {"tools", "Tool", Screen::kCut, kLeft, [](PanelFrame& f) { drawTools(f.context, f.state.tools); }},
    {"replay", "Replay", Screen::kReplay, kRight, drawReplayMoment},
    {"readings", "Cut", Screen::kCut, kRight, drawReadings},
    {"saw", "Saw plan", Screen::kCut, kRight, [](PanelFrame& f) { drawSawPanel(f.context, f.state.saw); },
     isSawPanelNeeded},
    {"drill", "Drill hole", Screen::kCut, kRight, [](PanelFrame& f) { drawDrillPanel(f.context, f.state.drill); },
     isDrillPanelNeeded},
    {"pieces", "Pieces", Screen::kCut, kRight, [](PanelFrame& f) { drawPieces(f.context); }, arePiecesNeeded},
    {"neighbours", "Neighbours", Screen::kCut, kRight, [](PanelFrame& f) { drawNeighbourList(f.context); },
     areNeighboursNeeded},
    {"tissues", "Tissues", Screen::kAny, kRight, [](PanelFrame& f) { drawTissues(f.context); }, areTissuesNeeded},
    {"plots", "Last 20 s", Screen::kAny, kFolded, drawPlots},
    {"details", "Details", Screen::kCut, kFolded, drawLoop},
    {"replay-strip", "", Screen::kReplay, kOwn, [](PanelFrame& f) { drawReplayStrip(f.context); }},
    {"hole", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawPlannedHole(f.context, f.state.drill, f.state.pixels); }},
    {"handles", "", Screen::kCut, kOwn,
     [](PanelFrame& f) { drawPieceHandles(f.context, f.state.piece_drag, f.state.pixels); }},
    {"picking", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawPickingHint(f.context); }},
    {"measure", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawMeasure(f.context, f.state.pixels); }},
    {"scale", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawScaleBar(f.context, f.state.pixels); }},
    {"tour", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawTour(f.context, f.state.tour_step); }},
    {"label", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawLabel(f.context); }},
    // The last one of a cut: taking a branch ends the session.
    {"timeline", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawTimeline(f.context); }},
    {"edges", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawColumnEdges(f.context); }},
    {"export", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawExportPanel(f.context, f.state.ask_for_file); }},
    {"device", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawDevicePanel(f.context, f.state.devices); }},
    {"sessions", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawSessions(f.context, f.state.sessions); }},
    {"settings", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawSettings(f.context); }},
    {"keys", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawKeys(f.context); }},
    {"messages", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawMessages(f.context); }},
    {"about", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawAbout(f.context); }},
    {"context", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawContextMenu(f.context, f.state.menu_at); }},
    {"quit", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawQuitQuestion(f.context); }},
    {"job", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawJob(f.context); }},
    {"notices", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawNotices(f.context, f.state.notices); }},
};

// Asked for each row: a command of a row above may have ended the document.
bool isShown(const Panel& panel, const AppContext& context) {
  const Screen now = screenOf(context.bench);
  if (panel.screen != Screen::kAny && panel.screen != now) return false;
  return panel.place == kOwn ||
         ((now == Screen::kCut || now == Screen::kReplay) && (!panel.is_needed || panel.is_needed(context)));
}

// The switch of a folded one follows the fold.
void drawSection(PanelFrame& frame, const Panel& panel) {
  bool& is_on = frame.context.panels[panel.id];
  const bool is_folded = panel.place == kFolded;
  ImGui::SetNextItemOpen(!is_folded || is_on, is_folded ? ImGuiCond_Always : ImGuiCond_Once);
  const bool is_open = ui::collapsingHeader(panel.title);
  if (is_folded) is_on = is_open;
  if (!is_open) return;
  ImGui::PushID(panel.id.data());
  ImGui::PushTextWrapPos(0);
  panel.draw(frame);
  ImGui::PopTextWrapPos();
  ImGui::PopID();
  ImGui::Dummy({0, scaled(4)});
}

// A docked window that scrolls. Sections of `first` head it.
void drawColumn(PanelFrame& frame, std::span<const Panel> rows, const char* id, const FrameArea& at,
                std::initializer_list<PanelPlace> places) {
  if (at.width() <= 0) return;
  ImGui::SetNextWindowPos({at.left, at.top}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({at.width(), at.height()}, ImGuiCond_Always);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::SetNextWindowBgAlpha(1);
  ui::begin(id, nullptr,
            ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PopStyleVar();
  for (const PanelPlace place : places)
    for (const Panel& panel : rows)
      if (panel.place == place && isShown(panel, frame.context)) drawSection(frame, panel);
  ImGui::End();
}

}  // namespace

std::span<const Panel> panelRows() { return kPanels; }

void drawPanels(AppContext& context, PanelState& state, const std::optional<ToolOverSurface>& over,
                std::span<const Panel> rows) {
  PanelFrame frame{context, state, over};
  const FrameLayout layout = frameLayout(context);
  const Screen screen = screenOf(context.bench);
  if (screen == Screen::kCut || screen == Screen::kReplay) {
    drawColumn(frame, rows, "##left", layout.left, {kLeft});
    if (layout.is_single)
      drawColumn(frame, rows, "##right", layout.right, {kLeft, kRight, kFolded});
    else
      drawColumn(frame, rows, "##right", layout.right, {kRight, kFolded});
  }
  for (const Panel& panel : rows)
    if (panel.place == kOwn && isShown(panel, context)) panel.draw(frame);
}

}  // namespace kerf
