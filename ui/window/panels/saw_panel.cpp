#include "ui/window/panels/saw_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <array>
#include <cmath>
#include <vector>

#include "ui/app/workbench/sawing.h"

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/tools.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kValueAt = 96, kStepWidth = 30;
constexpr double kStepMm = 0.1, kStepDegrees = 1, kFine = 0.1;  // Shift: a tenth of it
const ImVec4 kQuiet{0.42f, 0.45f, 0.50f, 1}, kAccent{0.10f, 0.42f, 0.62f, 1}, kWhite{1, 1, 1, 1};

void runSaw(AppContext& context, const char* id, const std::vector<std::string>& words = {}) {
  if (const auto done = runAppCommand(context, id, words); !done) context.bench.notices->complain(done.error());
}

// A name, a value, and two buttons that step it. Held, they repeat.
void stepper(AppContext& context, const char* name, const std::string& value, const char* command, double step,
             double base = 0) {
  ImGui::PushID(name);
  ImGui::AlignTextToFramePadding();
  ui::textColored(kQuiet, name);
  ui::sameLineAt(kValueAt);
  ui::text(value);

  const double by = ImGui::GetIO().KeyShift ? kFine * step : step;
  const float right = ImGui::GetWindowContentRegionMax().x;
  ImGui::PushButtonRepeat(true);
  ImGui::SameLine(right - 2 * kStepWidth - 4);
  if (ui::button("-", {kStepWidth, 0})) runSaw(context, command, {fmt::format("{:.9g}", base - by)});
  ImGui::SameLine(right - kStepWidth);
  if (ui::button("+", {kStepWidth, 0})) runSaw(context, command, {fmt::format("{:.9g}", base + by)});
  ImGui::PopButtonRepeat();
  if (ImGui::IsItemHovered()) ui::setTooltip("Shift: 10 times finer steps");
  ImGui::PopID();
}

bool wideButton(const char* label, bool is_main) {
  if (is_main) {
    ImGui::PushStyleColor(ImGuiCol_Button, kAccent);
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ImVec4(0.14f, 0.50f, 0.72f, 1));
    ImGui::PushStyleColor(ImGuiCol_ButtonActive, ImVec4(0.07f, 0.34f, 0.52f, 1));
    ImGui::PushStyleColor(ImGuiCol_Text, kWhite);
  }
  const bool is_pressed = ui::button(label, {-1, 30});
  if (is_main) ImGui::PopStyleColor(4);
  return is_pressed;
}

void drawProgress(AppContext& context, const SawingStatus& status) {
  ui::text(phrase("Sawing {}", status.plane));
  const std::string done = phrase("{:.0f} % of the plane", std::floor(100 * status.share));
  ui::progressBar(static_cast<float>(status.share), {-1, 0}, done);
  std::string line = fmt::format("{:.0f} s", status.seconds);
  if (status.left_s && !status.is_stopping) line += phrase(", about {:.0f} s left", std::ceil(*status.left_s));
  ui::textColored(kQuiet, line);
  const std::string volumes = phrase("{:.1f} of {:.1f} mm3", status.removed_mm3, status.planned_mm3);
  ui::textColored(kQuiet, volumes);
  if (status.is_stopping)
    ui::text("Retracting the blade...");
  else if (wideButton("Stop", false))
    runSaw(context, "saw.stop");
}

void drawWaysOfPlanning(AppContext& context) {
  const float width = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  static constexpr std::array<std::array<const char*, 3>, 3> kWays = {
      {{"Line", "saw.pick-line", "Draw a line across the bone (L)"},
       {"3 points", "saw.pick-points", "Pick three points of the bone (P)"},
       {"Face", "saw.pick-face", "Click a face: parallel to it"}}};
  for (std::size_t n = 0; n < kWays.size(); ++n) {
    if (n > 0) ImGui::SameLine();
    if (ui::button(kWays[n][0], {width, 0})) runSaw(context, kWays[n][1]);
    if (ImGui::IsItemHovered()) ui::setTooltip(kWays[n][2]);
  }
}

void drawPlanes(AppContext& context, SawPanelState& state) {
  Sawing& saw = *context.bench.saw;
  const SawPlan& plan = saw.plan();
  for (std::size_t n = 0; n < plan.planes().size(); ++n) {
    const SawPlane& plane = plan.planes()[n];
    const std::string label = fmt::format("{}###plane{}", plane.name, n);
    if (ui::selectable(ui::asItIs(label), n == plan.chosenIndex())) saw.plan().choose(n);
  }

  if (plan.version() != state.version) {
    state.version = plan.version();
    state.name = plan.chosen()->name;
  }
  std::array<char, 61> text{};
  state.name.copy(text.data(), text.size() - 1);
  ImGui::PushItemWidth(ImGui::GetContentRegionAvail().x - 70);
  if (ui::inputText("##name", text.data(), text.size())) state.name = text.data();
  if (ImGui::IsItemDeactivatedAfterEdit()) runSaw(context, "saw.rename", {state.name});
  ImGui::PopItemWidth();
  ImGui::SameLine();
  if (ui::button("Delete", {-1, 0})) runSaw(context, "saw.delete");
}

void drawSteppers(AppContext& context) {
  const SawPlane plane = *context.bench.saw->plan().chosen();
  stepper(context, "Move", "by 0.1 mm", "saw.move", kStepMm);
  stepper(context, "Turn", "by 1 degree", "saw.turn", kStepDegrees);
  stepper(context, "Tilt", "by 1 degree", "saw.tilt", kStepDegrees);
  stepper(context, "Approach", "by 5 degrees", "saw.approach", 5 * kStepDegrees);
  stepper(context, "Width", fmt::format("{:.1f} mm", plane.width), "saw.width", 5 * kStepMm, plane.width);
  stepper(context, "Depth", fmt::format("{:.1f} mm", plane.depth), "saw.depth", 5 * kStepMm, plane.depth);
}

void drawClearance(AppContext& context) {
  constexpr double kClose = 2;  // mm: below this it warns
  const auto left = context.bench.saw->clearance();
  if (!left) return;
  if (left->is_far)
    return ui::textColored(kQuiet, phrase("More than {:.0f} mm from all nerves and pulps", left->distance_mm));
  const std::string name = shownText(context.bench.document->nameOf(left->material));
  const std::string away = phrase("{:.1f} mm from the {}", left->distance_mm, name);
  if (left->distance_mm < 0)
    ui::textColored(styleColours().warning, phrase("Goes through the {}", name));
  else if (left->distance_mm < kClose)
    ui::textColored(styleColours().warning, away);
  else
    ui::text(away);
}

void drawCut(AppContext& context) {
  Sawing& saw = *context.bench.saw;
  drawClearance(context);
  bool is_guided = saw.guide;
  if (ui::checkbox("Guide blade by mouse", &is_guided)) runSaw(context, "saw.guide", {is_guided ? "on" : "off"});
  if (ImGui::IsItemHovered()) ui::setTooltip("Keeps a mouse-guided saw in this plane (G)");

  auto force = static_cast<float>(saw.force);
  ui::text("Push limit");
  ImGui::PushItemWidth(-1);
  if (ui::sliderFloat("##sawforce", &force, static_cast<float>(Sawing::kLeastForce),
                      static_cast<float>(Sawing::kMostForce), "%.1f N", ImGuiSliderFlags_AlwaysClamp))
    saw.force = static_cast<double>(force);
  ImGui::PopItemWidth();
  if (wideButton("Cut this plane", true)) runSaw(context, "saw.cut");
}

void drawCutAtOnce(AppContext& context) {
  ui::text("Cut at once, keep");
  const float width = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  static constexpr std::array<std::array<const char*, 3>, 3> kSides = {
      {{"Both", "plane.cut-keep-both", "Splits the piece along the whole plane"},
       {"Above", "plane.cut-keep-above", "Removes the part below the plane"},
       {"Below", "plane.cut-keep-below", "Removes the part above the plane"}}};
  for (std::size_t n = 0; n < kSides.size(); ++n) {
    if (n > 0) ImGui::SameLine();
    if (ui::button(kSides[n][0], {width, 0})) runSaw(context, kSides[n][1]);
    if (ImGui::IsItemHovered()) ui::setTooltip(kSides[n][2]);
  }
}

void drawHint(const Sawing& saw) {
  const std::string hint = saw.picking.hint();
  if (hint.empty()) return;
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos({0.5f * io.DisplaySize.x, ImGui::GetFrameHeight() + 12}, ImGuiCond_Always, {0.5f, 0});
  ui::begin("##sawhint", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                ImGuiWindowFlags_NoInputs);
  ui::textColored(kAccent, hint);
  ImGui::End();
}

}  // namespace

void drawSawPanel(AppContext& context, SawPanelState& state, PanelColumn& column) {
  Workbench& bench = context.bench;
  Sawing& saw = *bench.saw;
  drawHint(saw);
  const bool has_planes = saw.plan().chosen() != nullptr;
  if (!has_planes && !SawBlade::of(bench.tools->at(bench.tools->inHand()))) return;

  column.place();
  ui::begin("Saw plan", nullptr, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse);
  if (const auto status = saw.status()) {
    drawProgress(context, *status);
  } else {
    if (!has_planes) ui::textColored(kQuiet, "Plan a cut from");
    drawWaysOfPlanning(context);
    if (has_planes) {
      ImGui::Separator();
      drawPlanes(context, state);
    }
    if (saw.plan().chosen()) {
      drawSteppers(context);
      ImGui::Separator();
      drawCutAtOnce(context);
      ImGui::Separator();
      drawCut(context);
    }
  }
  column.take();
  ImGui::End();
}

}  // namespace kerf
