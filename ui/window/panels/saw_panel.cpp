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
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"
#include "ui/window/panels/die_panel.h"

namespace kerf {
namespace {

constexpr float kValueAt = 84, kStepWidth = 28;                 // before scaled()
constexpr double kStepMm = 0.1, kStepDegrees = 1, kFine = 0.1;  // Shift: a tenth of it

void runSaw(AppContext& context, const char* id, const std::vector<std::string>& words = {}) {
  if (const auto done = runAppCommand(context, id, words); !done) context.bench.notices->complain(done.error());
}

// A name, a value, and two buttons that step it. Held, they repeat.
void stepper(AppContext& context, const char* name, const std::string& value, const char* command, double step,
             double base = 0) {
  ImGui::PushID(name);
  ImGui::AlignTextToFramePadding();
  ui::textColored(styleColours().quiet, name);
  ui::sameLineAt(scaled(kValueAt));
  ui::text(value);

  const double by = ImGui::GetIO().KeyShift ? kFine * step : step;
  const float right = ImGui::GetWindowContentRegionMax().x, width = scaled(kStepWidth), gap = scaled(4);
  ImGui::PushButtonRepeat(true);
  ImGui::SameLine(right - 2 * width - gap);
  if (ui::button("-", {width, 0})) runSaw(context, command, {fmt::format("{:.9g}", base - by)});
  ImGui::SameLine(right - width);
  if (ui::button("+", {width, 0})) runSaw(context, command, {fmt::format("{:.9g}", base + by)});
  ImGui::PopButtonRepeat();
  if (ImGui::IsItemHovered()) ui::setTooltip("Shift: 10 times finer steps");
  ImGui::PopID();
}

void drawProgress(AppContext& context, const SawingStatus& status) {
  ui::text(phrase("Sawing {}", status.plane));
  const std::string done = phrase("{:.0f} % of the plane", std::floor(100 * status.share));
  ui::progressBar(static_cast<float>(status.share), {-1, 0}, done);
  std::string line = shownNumbers("{:.0f} s", status.seconds);
  if (status.left_s && !status.is_stopping) line += phrase(", about {:.0f} s left", std::ceil(*status.left_s));
  ui::textColored(styleColours().quiet, line);
  const std::string volumes = phrase("{:.1f} of {:.1f} mm3", status.removed_mm3, status.planned_mm3);
  ui::textColored(styleColours().quiet, volumes);
  if (status.is_stopping)
    ui::text("Retracting the blade...");
  else if (ui::button("Stop", {-1, 0}))
    runSaw(context, "saw.stop");
}

void drawWaysOfPlanning(AppContext& context, SawPanelState& state) {
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

  ImGui::PushItemWidth(width);
  ui::inputFloat("##undercusps", &state.above_cusps, "%.1f mm");
  ImGui::PopItemWidth();
  if (ImGui::IsItemHovered()) ui::setTooltip("Height over the cusps: negative is below");
  ImGui::SameLine();
  if (ui::button("Under the cusps", {-1, 0}))
    runSaw(context, "saw.plane-occlusal", wordsOf({static_cast<double>(state.above_cusps)}));
  if (ImGui::IsItemHovered()) ui::setTooltip("Parallel to the occlusal plane: trims a base");
  if (!context.bench.saw->plan().planes().empty()) return;  // later from the menu
  if (ui::button("Open saw plan...", {-1, 0}) && context.ask_for_file) context.ask_for_file("saw.load");
  if (ImGui::IsItemHovered()) ui::setTooltip("Planes of an earlier session or of 3D Slicer (.mrk.json)");
}

void drawPlanes(AppContext& context, SawPanelState& state) {
  Sawing& saw = *context.bench.saw;
  const SawPlan& plan = saw.plan();
  for (std::size_t n = 0; n < plan.planes().size(); ++n) {
    const SawPlane& plane = plan.planes()[n];
    const std::string label = fmt::format("{}###plane{}", plane.name, n);
    if (ui::selectable(ui::asItIs(label), n == plan.chosenIndex())) saw.choosePlane(n);
  }

  if (plan.version() != state.version) {
    state.version = plan.version();
    state.name = plan.chosen()->name;
  }
  std::array<char, 61> text{};
  state.name.copy(text.data(), text.size() - 1);
  ImGui::PushItemWidth(ImGui::GetContentRegionAvail().x - scaled(80));
  if (ui::inputText("##name", text.data(), text.size())) state.name = text.data();
  if (ImGui::IsItemDeactivatedAfterEdit()) runSaw(context, "saw.rename", {state.name});
  ImGui::PopItemWidth();
  ImGui::SameLine();
  if (ui::button("Delete", {-1, 0})) runSaw(context, "saw.delete");
}

void drawSteppers(AppContext& context) {
  const SawPlane plane = *context.bench.saw->plan().chosen();
  bool has_handles = context.bench.saw->has_handles;
  if (ui::checkbox("Handles on plane", &has_handles)) runSaw(context, "plane.handles", {has_handles ? "on" : "off"});
  if (ImGui::IsItemHovered()) ui::setTooltip("Drag arrows and rings in the view to move and turn the plane");
  stepper(context, "Move", "by 0.1 mm", "saw.move", kStepMm);
  stepper(context, "Turn", "by 1 degree", "saw.turn", kStepDegrees);
  stepper(context, "Tilt", "by 1 degree", "saw.tilt", kStepDegrees);
  stepper(context, "Approach", "by 5 degrees", "saw.approach", 5 * kStepDegrees);
  stepper(context, "Width", shownNumbers("{:.1f} mm", plane.width), "saw.width", 5 * kStepMm, plane.width);
  stepper(context, "Depth", shownNumbers("{:.1f} mm", plane.depth), "saw.depth", 5 * kStepMm, plane.depth);
  if (ui::button("Fit to bone and blade", {-1, 0})) runSaw(context, "saw.fit");
}

void drawClearance(AppContext& context) {
  constexpr double kClose = 2;  // mm: below this it warns
  const auto left = context.bench.saw->clearance();
  if (!left) return;
  if (left->is_far)
    return ui::textColored(styleColours().quiet,
                           phrase("More than {:.0f} mm from all nerves and pulps", left->distance_mm));
  const std::string name = shownText(context.bench.document->nameOf(left->material));
  const std::string away = phrase("{:.1f} mm from the {}", left->distance_mm, name);
  if (left->distance_mm < 0)
    ui::textColored(styleColours().warning, phrase("Goes through the {}", name));
  else if (left->distance_mm < kClose)
    ui::textColored(styleColours().warning, away);
  else
    ui::text(away);
}

// How far the blade gets, before it saws.
void drawCoverage(AppContext& context) {
  const auto covered = context.bench.saw->coverage();
  if (!covered) return;
  if (covered->passesThrough())
    ui::textColored(styleColours().quiet, shownText("Passes right through"));
  else
    ui::textColored(styleColours().warning,
                    phrase("Does not pass through ({:.0f} %)", std::floor(100 * covered->share)));
}

void drawCut(AppContext& context) {
  Sawing& saw = *context.bench.saw;
  ui::text("Saw it in real time");
  if (!SawBlade::of(context.bench.tools->at(context.bench.tools->inHand())))
    ui::textColored(styleColours().quiet, "Choose a saw in the list first");
  else
    drawCoverage(context);
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
  if (strongButton("Cut this plane", "", -1)) runSaw(context, "saw.cut");
}

void drawCutAtOnce(AppContext& context) {
  if (const auto covered = context.bench.saw->coverage(); covered && covered->sections > covered->sections_met)
    ui::textColored(styleColours().quiet,
                    phrase("Cuts {} more in this plane", covered->sections - covered->sections_met));
  if (const std::string beside = context.bench.saw->neighboursInPlane(); !beside.empty())
    ui::textWrapped(phrase("Stays whole: {} (neighbour). To cut it: Piece > Switch to neighbour", beside));
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

}  // namespace

void drawPickingHint(const AppContext& context) {
  const std::string hint = context.bench.saw->picking.hint();
  if (hint.empty()) return;
  const FrameArea free = frameLayout(context).free;
  ImGui::SetNextWindowPos({free.middle(), free.top + scaled(8)}, ImGuiCond_Always, {0.5f, 0});
  ui::begin("##sawhint", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                ImGuiWindowFlags_NoInputs);
  ImGui::PushTextWrapPos(free.width() - scaled(32));
  ui::textColored(styleColours().accent, hint);
  ImGui::PopTextWrapPos();
  ImGui::End();
}

bool isSawPanelNeeded(const AppContext& context) { return context.bench.document->isOpen(); }

void drawSawPanel(AppContext& context, SawPanelState& state) {
  const Sawing& saw = *context.bench.saw;
  if (const auto status = saw.status()) return drawProgress(context, *status);
  const bool has_planes = saw.plan().chosen() != nullptr;
  if (!has_planes) ui::textColored(styleColours().quiet, "Plan a cut from");
  drawWaysOfPlanning(context, state);
  drawDie(context);
  if (has_planes) {
    ImGui::Separator();
    drawPlanes(context, state);
  }
  if (!saw.plan().chosen()) return;  // it was deleted now
  drawSteppers(context);
  ImGui::Separator();
  drawCutAtOnce(context);
  ImGui::Separator();
  drawCut(context);
}

}  // namespace kerf
