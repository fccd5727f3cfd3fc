#include "ui/window/panels/panels.h"

#include <imgui.h>

#include <algorithm>
#include <string>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
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
#include "ui/window/panels/measure_panel.h"
#include "ui/window/panels/plots_panel.h"
#include "ui/window/panels/readings_panel.h"
#include "ui/window/panels/replay_panel.h"
#include "ui/window/panels/settings_panel.h"
#include "ui/window/panels/tissues_panel.h"
#include "ui/window/screens/quit_question.h"
#include "ui/window/screens/scale_bar.h"

namespace kerf {
namespace {

// Left of the readings, over the timeline.
void drawScaleBar(const AppContext& context, double pixels) {
  const ImGuiIO& io = ImGui::GetIO();
  drawScaleBarAt({io.DisplaySize.x - scaled(kPanelWidth) - 32, io.DisplaySize.y - timelineHeight(context) - 20},
                 context.camera, context.width, context.height, pixels, styleColours().guide_text);
}

// Reason why the stroke removes nothing, in the middle above the timeline, while it lasts.
void drawHindrance(const AppContext& context) {
  const char* const text = context.bench.monitor->hindrance();
  if (!text[0]) return;
  const ImGuiIO& io = ImGui::GetIO();
  const NoticePlace at =
      noticePlace(io.DisplaySize.x, io.DisplaySize.y, ImGui::GetFrameHeight(), scaled(1), SidePanels::kBoth);
  ImGui::SetNextWindowPos({at.middle, io.DisplaySize.y - 8 - timelineHeight(context)}, ImGuiCond_Always, {0.5f, 1});
  ui::begin("##hindrance", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PushTextWrapPos(std::min(at.width, scaled(460)));
  ui::textColored(styleColours().warning, text);
  ImGui::PopTextWrapPos();
  ImGui::End();
}

void drawHints(AppContext& context) {
  if (!context.settings || context.settings->values.are_hints_dismissed) return;
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos({scaled(kPanelWidth) + 16, io.DisplaySize.y - 8 - timelineHeight(context)}, ImGuiCond_Always,
                          {0, 1});
  ui::begin("##hints", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove);
  ui::textColored(styleColours().accent, "Left button on the object: cut. Hold still to cut down to the depth limit.");
  ui::text("Shift: double push. Wheel while cutting: change the depth limit.");
  ui::text("Alt and drag: tilt the tool. Ctrl while cutting: move along its axis.");
  ui::text("Space: foot pedal. Arrows, Home and End with it: small steps.");
  ui::text("Right button: turn. Middle button: move. Wheel: zoom.");
  if (ui::smallButton("Got it"))
    if (const auto done = runAppCommand(context, "view.hints", std::vector<std::string>{"off"}); !done)
      context.bench.notices->complain(done.error());
  ImGui::End();
}

// The table. A row below draws over those above it.
constexpr auto kOwn = PanelPlace::kOwn;
constexpr Panel kPanels[] = {
    {"menu", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawMainMenu(f.context, f.state.ask_for_file); }},
    {"first", "", Screen::kFirst, kOwn, [](PanelFrame& f) { f.state.first.draw(f.context, f.state.ask_for_file); }},
    {"import", "", Screen::kImport, kOwn, [](PanelFrame& f) { drawImportPanel(f.context, f.state.import); }},
    {"replay", "Replay", Screen::kReplay, PanelPlace::kColumn, drawReplayMoment},
    {"replay-tissues", "", Screen::kReplay, kOwn, [](PanelFrame& f) { drawTissues(f.context, f.column); }},
    {"replay-strip", "", Screen::kReplay, kOwn, [](PanelFrame& f) { drawReplayStrip(f.context); }},
    {"tools", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawTools(f.context, f.state.tools); }},
    {"readings", "Cut", Screen::kCut, PanelPlace::kColumn, drawReadings},
    {"plots", "Last 20 s", Screen::kAny, PanelPlace::kReadings, drawPlots},
    {"details", "Details", Screen::kCut, PanelPlace::kReadings, drawLoop},
    {"pieces", "", Screen::kCut, kOwn,
     [](PanelFrame& f) { drawPieces(f.context, f.state.piece_drag, f.column, f.state.pixels); }},
    {"saw", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawSawPanel(f.context, f.state.saw, f.column); }},
    {"tissues", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawTissues(f.context, f.column); }},
    {"measure", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawMeasure(f.context, f.state.pixels); }},
    {"scale", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawScaleBar(f.context, f.state.pixels); }},
    {"hints", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawHints(f.context); }},
    {"hindrance", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawHindrance(f.context); }},
    {"export", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawExportPanel(f.context, f.state.ask_for_file); }},
    // The last one of a cut: taking a branch ends the session.
    {"timeline", "", Screen::kCut, kOwn, [](PanelFrame& f) { drawTimeline(f.context); }},
    {"device", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawDevicePanel(f.context, f.state.devices); }},
    {"sessions", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawSessions(f.context, f.state.sessions); }},
    {"settings", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawSettings(f.context); }},
    {"quit", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawQuitQuestion(f.context); }},
    {"job", "", Screen::kAny, kOwn, [](PanelFrame& f) { drawJob(f.context); }},
    {"notices", "", Screen::kAny, kOwn,
     [](PanelFrame& f) { drawNotices(f.context, f.state.notices_seen, f.state.notices_drawn); }},
};

Screen screenOf(const Workbench& bench) {
  if (bench.imports->isImporting()) return Screen::kImport;
  if (bench.document->watched()) return Screen::kReplay;
  return bench.document->isOpen() ? Screen::kCut : Screen::kFirst;
}

void drawInColumn(PanelFrame& frame, const Panel& panel) {
  frame.column.place();
  ui::begin(std::string(panel.title).c_str(), nullptr,
            ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse);
  panel.draw(frame);
  frame.column.take();
  ImGui::End();
}

}  // namespace

std::span<const Panel> panelRows() { return kPanels; }

void drawPanels(AppContext& context, PanelState& state, const std::optional<ToolOverSurface>& over,
                std::span<const Panel> rows) {
  PanelColumn column(context);
  PanelFrame frame{context, state, over, column};
  for (const Panel& panel : rows) {
    // Asked for each row: a command of a row above may have ended the document.
    if (panel.screen != Screen::kAny && panel.screen != screenOf(context.bench)) continue;
    if (panel.place == PanelPlace::kOwn) panel.draw(frame);
    if (panel.place == PanelPlace::kColumn) drawInColumn(frame, panel);
  }
}

}  // namespace kerf
