#include "ui/window/panels/drill_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/drilling.h"
#include "ui/app/workbench/strokes.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kHoleValueAt = 90;
constexpr std::array<const char*, 4> kHoleAxes{"Vertical", "Occlusal", "Surface", "View"};
constexpr std::array<const char*, 4> kHoleAxisWords{"vertical", "occlusal", "face", "view"};
constexpr ImU32 kDimension = IM_COL32(250, 250, 250, 255), kHoleLine = IM_COL32(60, 170, 235, 255),
                kHoleEdge = IM_COL32(20, 24, 30, 230);

// "12 8", "12,5 8", "12,8" or "12; 8".
std::vector<std::string> numbersOf(std::string text) {
  const bool has_space = text.find_first_of(" ;") != text.npos;
  std::replace(text.begin(), text.end(), ';', ' ');
  std::replace(text.begin(), text.end(), ',', has_space ? '.' : ' ');
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string word; in >> word;) out.push_back(word);
  return out;
}

template <std::size_t kSize>
void setHoleText(std::array<char, kSize>& text, const std::string& value) {
  text.fill('\0');
  value.copy(text.data(), kSize - 1);
}

// @return  true when the text is to be taken: entered, or left with another text than it was entered with.
bool holeField(const char* name, std::array<char, 48>& text, float width) {
  static std::array<char, 48> before{};  // of the active field
  ImGui::AlignTextToFramePadding();
  ui::textColored(styleColours().quiet, name);
  ui::sameLineAt(scaled(kHoleValueAt));
  ImGui::PushID(name);
  ImGui::PushItemWidth(width);
  const bool is_entered = ui::inputText("##value", text.data(), text.size(),
                                        ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  ImGui::PopItemWidth();
  ImGui::PopID();
  if (ImGui::IsItemActivated()) before = text;
  return is_entered || (ImGui::IsItemDeactivatedAfterEdit() && text != before);
}

void drawHolePlace(AppContext& context, DrillPanelState& state, const std::optional<HoleReadout>& readout) {
  const std::optional<Hole>& hole = context.bench.drill->hole();
  if (hole && state.shown != hole->entry) {
    state.shown = hole->entry;
    setHoleText(state.place, shownNumbers("{:.1f} {:.1f}", readout->place[0], readout->place[1]));
  }
  // While a typed hole is drilled, the next place is awaited. A window that appears may take the keys away.
  if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) state.is_typed = false;
  if (state.is_typed && context.bench.drill->isDrilling() && !ImGui::IsAnyItemActive()) state.focus_in = 1;
  if (state.focus_in > 1) {
    --state.focus_in;
  } else if (state.focus_in == 1) {
    if (!ImGui::IsWindowFocused()) ImGui::SetWindowFocus();  // Dear ImGui 1.90 finds no field of another window
    ImGui::SetKeyboardFocusHere();
  }
  const bool is_taken = holeField("x, y in mm", state.place, -1);
  if (state.focus_in == 1 && ImGui::IsItemActive()) state.focus_in = 0;
  if (!is_taken) return;
  state.is_typed = true;
  state.shown.reset();
  if (const auto done = runAppCommand(context, "drill.at", numbersOf(state.place.data())); !done) {
    context.bench.notices->complain(done.error());
    state.focus_in = 1;  // to be corrected
  }
  if (hole) state.shown = hole->entry;  // the text stays as typed
}

void drawHoleDepth(AppContext& context, DrillPanelState& state) {
  const Drilling& drill = *context.bench.drill;
  if (state.shown_depth != drill.depth()) {
    state.shown_depth = drill.depth();
    setHoleText(state.depth, shownNumbers("{:g}", drill.depth()));
  }
  bool is_through = drill.isThrough();
  if (holeField("Depth in mm", state.depth, scaled(48))) {
    std::string mm = state.depth.data();
    std::replace(mm.begin(), mm.end(), ',', '.');
    runIfEnabled(context, "drill.depth", std::vector<std::string>{mm});
    state.shown_depth.reset();
  }
  ImGui::SameLine();
  if (ui::checkbox("Through", &is_through))
    runIfEnabled(context, "drill.depth",
                 std::vector<std::string>{is_through ? "through" : fmt::format("{}", drill.depth())});
}

void drawHoleAxis(AppContext& context) {
  ImGui::AlignTextToFramePadding();
  ui::textColored(styleColours().quiet, "Axis");
  ui::sameLineAt(scaled(kHoleValueAt));
  if (context.bench.strokes->heldAxis()) return ui::text("Held axis");
  const auto chosen = static_cast<std::size_t>(context.bench.drill->axis());
  ImGui::PushItemWidth(-1);
  if (ui::beginCombo("##axis", kHoleAxes[chosen])) {
    for (std::size_t n = 0; n < kHoleAxes.size(); ++n)
      if (ui::selectable(kHoleAxes[n], n == chosen))
        runIfEnabled(context, "drill.axis", std::vector<std::string>{kHoleAxisWords[n]});
    ImGui::EndCombo();
  }
  ImGui::PopItemWidth();
}

void drawHoleNumbers(const AppContext& context, const HoleReadout& readout) {
  constexpr double kThin = 1;  // mm: less is warned of
  const HoleWalls& walls = readout.walls;
  const auto tell = [](const std::string& text, double wall) {
    ui::textColored(wall < kThin ? styleColours().warning : ImGui::GetStyleColorVec4(ImGuiCol_Text), text);
  };
  if (walls.edge) ui::text(phrase("{:.1f} mm to the nearest edge", *walls.edge));
  if (walls.beside && *walls.beside > 0)
    tell(phrase("{:.1f} mm of wall beside", *walls.beside), *walls.beside);
  else if (walls.beside)
    tell(shownText("Breaks out at the side"), 0);
  if (walls.beneath && *walls.beneath > 0)
    tell(phrase("{:.1f} mm left beneath", *walls.beneath), *walls.beneath);
  else
    ui::text("Comes out at the other side");
  if (walls.beneath && *walls.beneath > 0 && readout.full_to < context.bench.drill->hole()->depth - 0.05)
    ui::text(phrase("{:.1f} mm wide, full width to {:.1f} mm", readout.diameter, readout.full_to));
  else
    ui::text(phrase("{:.1f} mm wide", readout.diameter));
  const Vec3d& p = context.bench.drill->hole()->entry;
  ui::textColored(styleColours().quiet, phrase("Scan {:.2f}, {:.2f}, {:.2f}", p[0], p[1], p[2]));
}

void drawHoleProgress(AppContext& context, const DrillingStatus& status) {
  const float share = static_cast<float>(std::clamp(status.depth / status.of_depth, 0.0, 1.0));
  ui::progressBar(share, {-1, 0}, phrase("{:.1f} of {:.1f} mm", std::max(status.depth, 0.0), status.of_depth));
  if (status.is_stopping)
    ui::text("Retracting the drill...");
  else if (plainButton("Stop", "", ImGui::GetContentRegionAvail().x))
    runIfEnabled(context, "drill.stop");
}

// The hole, and its distances from the corner at the height of its entry.
void drawHole(AppContext& context, const HoleReadout& readout, double pixels) {
  constexpr int kCircle = 24;
  const Drilling& drill = *context.bench.drill;
  const Hole& hole = *drill.hole();
  ImDrawList* const draw = ImGui::GetBackgroundDrawList();
  const auto at = [&](const Vec3d& point) {
    const auto pixel = pixelOf(context.camera, point, context.width, context.height);
    return ImVec2(static_cast<float>(pixel[0] / pixels), static_cast<float>(pixel[1] / pixels));
  };
  const auto line = [&](const Vec3d& from, const Vec3d& to, ImU32 colour) {
    draw->AddLine(at(from), at(to), kHoleEdge, 4);
    draw->AddLine(at(from), at(to), colour, 2);
  };
  const Vec3d across = hole.axis.unitOrthogonal(), along = hole.axis.cross(across);
  const Vec3d bottom = hole.entry - hole.depth * hole.axis;
  for (const Vec3d& middle : {hole.entry, bottom})
    for (int n = 0; n < kCircle; ++n) {
      const auto rim = [&](int k) -> Vec3d {
        const double angle = 2 * std::numbers::pi * k / kCircle;
        return middle + drill.radius() * (std::cos(angle) * across + std::sin(angle) * along);
      };
      line(rim(n), rim(n + 1), kHoleLine);
    }
  line(hole.entry + 3 * hole.axis, bottom, kHoleLine);

  const Box3 box = drill.boxIn(context.camera);
  const Eigen::Matrix3d to_world = context.camera.upright.transpose();
  const double height = box.min[2] + readout.place[2];
  const Vec3d corner = to_world * Vec3d(box.min[0], box.min[1], height);
  const Vec3d foot = to_world * Vec3d(box.min[0] + readout.place[0], box.min[1], height);
  const auto label = [&](const Vec3d& from, const Vec3d& to, double mm) {
    line(from, to, kDimension);
    const std::string text = shownNumbers("{:.1f}", mm);
    const ImVec2 middle = at(0.5 * (from + to)), size = ui::textSize(text);
    draw->AddRectFilled({middle.x - 4, middle.y - 2}, {middle.x + size.x + 4, middle.y + size.y + 2}, kHoleEdge, 4);
    ui::addText(*draw, middle, kDimension, text);
  };
  label(corner, foot, readout.place[0]);
  label(foot, hole.entry, readout.place[1]);
}

}  // namespace

bool isDrillPanelNeeded(const AppContext& context) {
  return context.bench.drill->isPlanning() || context.bench.drill->status();
}

void drawPlannedHole(AppContext& context, DrillPanelState& state, double pixels) {
  const Drilling& drill = *context.bench.drill;
  const bool is_shown = isDrillPanelNeeded(context);
  if (is_shown && !state.was_shown) state.focus_in = 3;  // the key that opened it is no text
  state.was_shown = is_shown;
  if (!is_shown) return;
  if (const auto readout = drill.readout(context.camera)) drawHole(context, *readout, pixels);
}

void drawDrillPanel(AppContext& context, DrillPanelState& state) {
  const Drilling& drill = *context.bench.drill;
  const auto status = drill.status();
  drawHolePlace(context, state, drill.readout(context.camera));
  drawHoleDepth(context, state);
  drawHoleAxis(context);
  ImGui::Separator();
  const auto now = drill.readout(context.camera);  // the controls may have changed it
  if (now)
    drawHoleNumbers(context, *now);
  else if (!status)
    ui::textColored(styleColours().quiet, "Click the model, or type x and y");
  if (status)
    drawHoleProgress(context, *status);
  else if (now && strongButton("Drill", "Enter", ImGui::GetContentRegionAvail().x))
    runIfEnabled(context, "drill.go");
}

}  // namespace kerf
