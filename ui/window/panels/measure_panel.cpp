#include "ui/window/panels/measure_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <string>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/view_state.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr ImU32 kLine = IM_COL32(250, 250, 250, 255), kEdge = IM_COL32(20, 24, 30, 230);
constexpr float kPoint = 4;

}  // namespace

void drawMeasure(AppContext& context, double pixels) {
  const Measure& measure = context.bench.views->measure;
  if (measure.points().empty()) return;

  // On top of everything: the measured point may be hidden.
  ImDrawList* const draw = ImGui::GetBackgroundDrawList();
  std::vector<ImVec2> at;
  for (const Vec3d& point : measure.points()) {
    const auto pixel = pixelOf(context.camera, point, context.width, context.height);
    at.emplace_back(static_cast<float>(pixel[0] / pixels), static_cast<float>(pixel[1] / pixels));
  }
  for (std::size_t n = 0; n + 1 < at.size(); ++n) {
    draw->AddLine(at[n], at[n + 1], kEdge, 4);
    draw->AddLine(at[n], at[n + 1], kLine, 2);
    const ImVec2 middle{0.5f * (at[n].x + at[n + 1].x) + 8, 0.5f * (at[n].y + at[n + 1].y) - 8};
    const std::string text = shownNumbers("{:.2f} mm", measure.distance(n));
    const ImVec2 size = ui::textSize(text);
    draw->AddRectFilled({middle.x - 4, middle.y - 2}, {middle.x + size.x + 4, middle.y + size.y + 2}, kEdge, 4);
    ui::addText(*draw, middle, kLine, text);
  }
  for (std::size_t n = 0; n < at.size(); ++n) {
    draw->AddCircleFilled(at[n], scaled(kPoint) + 1, kEdge);
    draw->AddCircleFilled(at[n], scaled(kPoint), kLine);
    if (n == 0 || n + 1 >= at.size()) continue;
    const std::string text = phrase("{:.1f} deg", measure.angle(n));
    ui::addText(*draw, {at[n].x + 8, at[n].y + 8}, kEdge, text);
  }
}

}  // namespace kerf
