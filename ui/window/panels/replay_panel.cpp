#include "ui/window/panels/replay_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sim/run/session/watched_run.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/replays.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/app/workbench/tools.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"
#include "ui/window/screens/readings.h"

namespace kerf {
namespace {

constexpr float kBarHeight = 22;  // before scaled()

void give(AppContext& context, const char* command, const std::vector<std::string>& words = {}) {
  if (const auto done = runAppCommand(context, command, words); !done) context.bench.notices->complain(done.error());
}

void button(AppContext& context, const char* label, const char* command, bool is_enabled = true) {
  ImGui::BeginDisabled(!is_enabled);
  if (ui::button(label)) give(context, command);
  ImGui::EndDisabled();
  ImGui::SameLine();
}

void drawSpeeds(AppContext& context, const WatchMoment& now) {
  struct Row {
    const char* label;
    const char* word;
    double speed;
  };
  static constexpr Row kRows[] = {
      {"0.25x", "0.25", 0.25}, {"0.5x", "0.5", 0.5}, {"1x", "1", 1},    {"2x", "2", 2},
      {"4x", "4", 4},          {"8x", "8", 8},       {"16x", "16", 16}, {"fastest", "fastest", WatchedRun::kFastest}};
  std::string shown = shownNumbers("{:g}x", now.speed);
  for (const Row& row : kRows)
    if (row.speed == now.speed) shown = row.label;
  ImGui::SetNextItemWidth(scaled(90));
  if (!ui::beginCombo("##speed", shown)) return;
  for (const Row& row : kRows)
    if (ui::selectable(row.label, row.speed == now.speed)) give(context, "replay.speed", {row.word});
  ImGui::EndCombo();
}

std::string stateOf(const WatchedRun& run) {
  const WatchMoment& now = run.moment();
  std::string out = phrase("{:.1f} of {:.1f} s, step {} of {}", kTick * static_cast<double>(now.sample), run.seconds(),
                           now.steps, run.steps().size());
  if (now.is_jumping) out += phrase(", jumping: {:.0f} %", 100 * now.jump_share);
  return out;
}

const char* nameOf(WatchedStep::Kind kind) {
  switch (kind) {
    case WatchedStep::Kind::kStroke:
      return "stroke";
    case WatchedStep::Kind::kMove:
      return "piece moved";
    case WatchedStep::Kind::kPlaneCut:
      return "plane cut";
    case WatchedStep::Kind::kDelete:
      return "piece deleted";
    case WatchedStep::Kind::kUndo:
      return "undone";
    case WatchedStep::Kind::kRedo:
      return "redone";
  }
  return "";
}

// A step is at least a line.
void drawSteps(const WatchedRun& run, const ImVec2& corner, float width, float height) {
  const StyleColours& colours = styleColours();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float per_sample = width / static_cast<float>(std::max<std::size_t>(run.samples(), 1));
  list.AddRectFilled(corner, {corner.x + width, corner.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg), 3);
  for (const WatchedStep& step : run.steps()) {
    ImVec4 colour = step.kind == WatchedStep::Kind::kStroke ? colours.accent : colours.quiet;
    if (step.kind == WatchedStep::Kind::kUndo) colour = colours.warning;
    if (step.end > run.moment().sample) colour.w *= 0.45f;
    const float from = corner.x + per_sample * static_cast<float>(step.begin);
    const float to = std::max(corner.x + per_sample * static_cast<float>(step.end), from + 2);
    list.AddRectFilled({from, corner.y + 3}, {to, corner.y + height - 3}, ImGui::GetColorU32(colour), 2);
  }
  const float now = corner.x + per_sample * static_cast<float>(run.moment().sample);
  list.AddLine({now, corner.y - 2}, {now, corner.y + height + 2}, ImGui::GetColorU32(ImGuiCol_Text), 2);
}

void drawStepUnder(const WatchedRun& run, std::size_t sample) {
  for (std::size_t n = 0; n < run.steps().size(); ++n) {
    const WatchedStep& step = run.steps()[n];
    if (sample < step.begin || sample > step.end) continue;
    const std::string tool = step.tool < run.tools().size() ? run.tools()[step.tool].id : "";
    ui::setTooltip(phrase("{}: {}, {}, at {:.1f} s", n + 1, shownText(nameOf(step.kind)), tool,
                          kTick * static_cast<double>(step.begin)));
    return;
  }
  ui::setTooltip(shownNumbers("{:.1f} s", kTick * static_cast<double>(sample)));
}

// The scrub bar follows a dragging mouse; it jumps when the mouse has moved.
void drawBar(AppContext& context) {
  WatchedRun& run = *context.bench.document->watched();
  const float width = std::max(ImGui::GetContentRegionAvail().x, scaled(60)), height = scaled(kBarHeight);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  ImGui::InvisibleButton("##scrub", {width, height});
  const ImGuiIO& io = ImGui::GetIO();
  const float share = std::clamp((io.MousePos.x - corner.x) / width, 0.0f, 1.0f);
  const auto sample = static_cast<std::size_t>(share * static_cast<float>(run.samples()));
  if (ImGui::IsItemHovered()) drawStepUnder(run, sample);
  const bool is_asked = ImGui::IsItemActivated() || (ImGui::IsItemActive() && io.MouseDelta.x != 0);
  if (is_asked) give(context, "replay.time", {fmt::format("{:.3f}", kTick * static_cast<double>(sample))});
  drawSteps(run, corner, width, height);
}

}  // namespace

void drawReplayStrip(AppContext& context) {
  const WatchedRun& run = *context.bench.document->watched();
  const WatchMoment& now = run.moment();
  const FrameArea at = frameLayout(context).strip;
  ImGui::SetNextWindowPos({at.left, at.top}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({at.width(), at.height()}, ImGuiCond_Always);
  ui::begin("##replay", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  button(context, "|<", "replay.begin");
  button(context, "<", "replay.previous");
  button(context, now.is_playing ? "Pause###play" : "Play###play", "replay.toggle");
  button(context, ">", "replay.next");
  button(context, ">|", "replay.end");
  drawSpeeds(context, now);
  ImGui::SameLine(0, scaled(16));
  ui::text(stateOf(run));
  ImGui::SameLine(0, scaled(16));
  button(context, "Continue cutting", "replay.go-on", !now.is_jumping && !context.bench.jobs->running());
  button(context, "Close", "replay.close");
  if (!context.bench.document->watched()) return ImGui::End();  // `run` and `now` are gone
  ImGui::NewLine();
  drawBar(context);
  if (now.verdict) {
    ImGui::PushTextWrapPos(0);
    ui::textColored(now.verdict->is_same ? styleColours().good : styleColours().warning, now.verdict->text);
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

void drawReplayMoment(PanelFrame& frame) {
  const Workbench& bench = frame.context.bench;
  const HapticReport& report = bench.document->report();
  reading("Tool", bench.tools->at(bench.tools->inHand()).id, "");
  reading("Force", shownNumbers("{:.2f}", report.output.force.force.norm()), "N");
  reading("Spindle", shownNumbers("{:.0f}", 100 * bench.monitor->driveShare()), "%");
  drawHeat(bench);
  reading("Removed", shownNumbers("{:.2f}", bench.document->removedMm3()), "mm3");
  reading("Pieces", fmt::format("{}", report.object_count), "");
}

}  // namespace kerf
