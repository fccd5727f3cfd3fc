#include "ui/window/panels/panels.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ui/app/base/language.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/readout/point_readout.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/window/gl/style.h"
#include "ui/window/gl/widgets.h"
#include "ui/window/panels/export_panel.h"
#include "ui/window/panels/measure_panel.h"
#include "ui/window/panels/notices.h"
#include "ui/window/panels/plots_panel.h"
#include "ui/window/panels/replay_panel.h"
#include "ui/window/panels/settings_panel.h"
#include "ui/window/panels/timeline_panel.h"
#include "ui/window/panels/tissues_panel.h"
#include "ui/window/screens/quit_question.h"
#include "ui/window/screens/readings.h"
#include "ui/window/screens/scale_bar.h"

namespace kerf {
namespace {

void runOrSay(AppContext& context, const AppCommand& command) {
  if (!command.is_enabled(context)) return;
  if (const auto done = command.run(context, {}); !done) context.bench.notices->complain(done.error());
}

// ---- Menus

void drawMenus(AppContext& context, PanelState& state) {
  if (!ImGui::BeginMainMenuBar()) return;
  for (const char* const heading : {"File", "Edit", "Tool", "Piece", "Saw", "Device", "Replay", "View"}) {
    if (!ui::beginMenu(heading)) continue;
    for (const AppCommand* const row : commandsOfMenu(heading)) {
      const AppCommand& command = *row;
      const std::string label = fmt::format("{}###{}", command.label, command.id);
      if (!ui::menuItem(label, ui::asItIs(shownKey(command.key)), command.is_enabled(context))) continue;
      asksForFile(command) ? state.ask_for_file(command) : runOrSay(context, command);
    }
    ImGui::EndMenu();
  }
  const std::string right = "Training and lab tool, not a medical device";
  ImGui::SameLine(ImGui::GetWindowWidth() - ui::textSize(right).x - 16);
  ui::textColored(styleColours().quiet, right);
  ImGui::EndMainMenuBar();
}

// ---- Readings

// Point under the guided tool or the cursor. Without one it keeps as many lines, so that panels below do not move.
void drawPoint(const AppContext& context, bool is_over) {
  std::optional<PointReadout> point = readoutOfTool(context.bench);
  if (is_over && context.pointer) {
    const auto& at = *context.pointer;
    point = readoutAt(context.bench, rayUnder(context.camera, at[0], at[1], context.width, context.height));
  }
  const Vec3d p = point ? point->point : Vec3d(Vec3d::Zero());
  reading("Point", point ? fmt::format("{:.2f}, {:.2f}, {:.2f}", p[0], p[1], p[2]) : "-", "");
  reading("Thickness", point && point->thickness_mm ? fmt::format("{:.2f}", *point->thickness_mm) : "-", "mm");
  reading("Tissue", point && !point->tissue.empty() ? point->tissue : "-", "");
}

// A warning that does not interrupt.
void drawNearStructure(const Workbench& bench, const std::optional<ToolOverSurface>& over) {
  constexpr double kClose = 0.5;  // mm
  if (bench.document->structures()->isEmpty()) return;
  const auto near = bench.monitor->nearStructure(over);
  const std::string name =
      near ? near->name : bench.document->nameOf(bench.document->structures()->all().front().material);
  const std::string label = phrase("To {}", shownText(name));
  if (!near) return reading(label.c_str(), "-", "mm");
  if (near->is_far) return reading(label.c_str(), phrase("over {:.0f}", near->distance_mm), "mm");
  if (near->distance_mm < 0)
    return reading(label.c_str(), fmt::format("{:.2f}", -near->distance_mm), "mm inside", true);
  reading(label.c_str(), fmt::format("{:.2f}", near->distance_mm), near->is_stopped ? "mm, stopped" : "mm",
          near->is_stopped || near->distance_mm < kClose);
}

// The same for neighbours: distance and removed volume.
void drawNeighbours(const Workbench& bench, const std::optional<ToolOverSurface>& over) {
  constexpr double kClose = 0.2;  // mm
  const std::vector<Neighbour> all = bench.neighbours->list();
  if (all.empty()) return;
  const auto near = bench.monitor->nearNeighbour(over);
  const std::string label = phrase("To {}", near ? near->name : all.front().name);
  if (!near)
    reading(label.c_str(), "-", "mm");
  else if (near->is_far)
    reading(label.c_str(), phrase("over {:.0f}", near->distance_mm), "mm");
  else if (near->distance_mm < 0)
    reading(label.c_str(), fmt::format("{:.2f}", -near->distance_mm), "mm inside", true);
  else
    reading(label.c_str(), fmt::format("{:.2f}", near->distance_mm), near->is_stopped ? "mm, stopped" : "mm",
            near->is_stopped || near->distance_mm < kClose);
  for (const Neighbour& other : all)
    if (other.removed_mm3 > 0)
      reading(phrase("Cut off {}", other.name).c_str(), fmt::format("{:.3f}", other.removed_mm3), "mm3", true);
}

// The 1 kHz loop: rate, duration, overruns.
void drawLoop(const Workbench& bench) {
  constexpr double kLeastHz = 995;
  const auto hz = bench.monitor->loopHz();
  reading("Loop", hz ? fmt::format("{:.0f}", *hz) : "-", "Hz", hz && *hz < kLeastHz);
  const TimeHistogram& cost = bench.document->times().cost;
  if (cost.count() > 0) reading("Tick p99", fmt::format("{:.2f}", cost.percentileMs(0.99)), "ms");
  const HapticCounts& counts = bench.document->report().counts;
  reading("Overruns", fmt::format("{}", counts.overruns), phrase("of {}", counts.ticks).c_str());
}

void drawReadings(AppContext& context, const std::optional<ToolOverSurface>& over, PanelColumn& column) {
  const Workbench& bench = context.bench;
  const HapticReport& r = bench.document->report();
  column.place();
  ui::begin("Cut", nullptr, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse);
  const double speed = std::abs(bench.monitor->driveShare());
  const char* const turns = bench.monitor->driveShare() < 0 ? "% reverse" : "%";
  const auto tip = bench.monitor->tipDepth();
  const auto depth = tip ? tip : over ? std::optional(over->depth) : std::nullopt;

  reading(tip ? "Depth of the tip" : "Depth", depth ? fmt::format("{:.2f}", *depth) : "-", "mm");
  drawNearStructure(bench, over);
  drawNeighbours(bench, over);
  reading("Force", fmt::format("{:.2f}", r.output.force.force.norm()), "N");
  reading("Spindle", fmt::format("{:.0f}", 100 * speed), turns,
          bench.strokes->isPressed() && speed < 0.05 && r.output.normal_load > 0);
  drawHeat(bench);
  reading("Removed", fmt::format("{:.2f}", bench.document->removedMm3()), "mm3");
  drawPoint(context, over.has_value());
  drawPlots(context);
  ImGui::Separator();
  drawLoop(bench);
  if (r.is_latched)
    ui::textColored(styleColours().warning, bench.device->isLed() ? "Stopped: waiting for the device."
                                                                  : "Stopped: the computer was busy. Press again.");
  const RecorderStatus log = bench.document->run()->recorderStatus();
  if (log.error)
    ui::textWrapped(phrase("Cannot write the log. End the session to keep your cuts. {}", log.error->message()));
  column.take();
  ImGui::End();
}

// ---- Job under way

void drawJob(AppContext& context) {
  const AnyJob* const job = context.bench.jobs->running();
  const ExportPlan& plan = *context.bench.exporting;
  if (!job || (plan.isShown() && plan.isBusy())) return;  // the export panel shows its own
  const JobStatus s = job->status();
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos({0.5f * io.DisplaySize.x, 0.5f * io.DisplaySize.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({440, 0}, ImGuiCond_Always);
  ui::begin("##job", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  ui::text(s.title);
  ui::progressBar(static_cast<float>(s.done), {-1, 0});
  std::string line = shownText(s.step);
  if (s.left_s) line += phrase("   about {:.0f} s left", std::ceil(*s.left_s));
  ui::textColored(styleColours().quiet, ui::asItIs(line));
  if (s.is_cancelling)
    ui::text("Cancelling...");
  else if (s.can_be_cancelled && ui::button("Cancel", {110, 0}))
    context.bench.jobs->cancel();
  ImGui::End();
}

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

}  // namespace

void drawPanels(AppContext& context, PanelState& state, const std::optional<ToolOverSurface>& over) {
  drawMenus(context, state);
  if (context.bench.imports->isImporting()) {
    drawImportPanel(context, state.import);
  } else if (context.bench.document->watched()) {
    drawReplay(context);
  } else if (context.bench.document->isOpen()) {
    drawTools(context, state.tools);
    PanelColumn column(context);
    drawReadings(context, over, column);
    drawPieces(context, state.piece_drag, column, state.pixels);
    drawTissues(context, column);
    drawMeasure(context, state.pixels);
    drawScaleBar(context, state.pixels);
    drawHints(context);
    drawHindrance(context);
    drawSawPanel(context, state.saw);
    drawExportPanel(context, state.ask_for_file);
    drawTimeline(context);  // last: taking a branch ends the session
  } else {
    state.first.draw(context, state.ask_for_file);
  }
  drawDevicePanel(context, state.devices);
  drawRunQuestion(context);
  drawSettings(context);
  drawQuitQuestion(context);
  drawJob(context);
  drawNotices(context, state.notices_seen, state.notices_drawn);
}

}  // namespace kerf
