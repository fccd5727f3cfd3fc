#include "ui/window/panels/import_trim.h"

#include <imgui.h>

#include <string>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/import/import_plan.h"
#include "ui/app/import/trim_drawing.h"
#include "ui/app/workbench/imports.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

using What = TrimDrawing::What;

void run(AppContext& context, const char* id, const std::vector<std::string>& words = {}) {
  if (const auto done = runAppCommand(context, id, words); !done) context.bench.notices->complain(done.error());
}

void drawWay(AppContext& context, const char* label, const char* word, What what, float width, const char* tip) {
  const bool is_on = context.bench.imports->drawing.what() == what;
  const StyleColours& colours = styleColours();
  if (is_on) {
    ImGui::PushStyleColor(ImGuiCol_Button, colours.strong);
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, colours.strong_hovered);
    ImGui::PushStyleColor(ImGuiCol_Text, colours.strong_text);
  }
  const bool is_pressed = ui::button(label, {width, 0});
  if (is_on) ImGui::PopStyleColor(3);
  if (is_pressed) run(context, "import.trim", {is_on ? "off" : word});
  if (ImGui::IsItemHovered()) ui::setTooltip(tip);
}

}  // namespace

void drawTrims(AppContext& context, const ImportPlan& plan) {
  heading("Cut away");
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  drawWay(context, "Lasso", "lasso", What::kLasso, half, "Draw around a part: it goes, through the whole scan.");
  ImGui::SameLine();
  drawWay(context, "Straight cut", "line", What::kLine, -1, "Draw a line across: the smaller part goes.");
  const TrimmedScan* const trimmed = plan.trimmed();
  if (!trimmed) return;

  ImGui::PushTextWrapPos(0);
  ui::text(phrase("{} triangles removed, {:.1f} mm2. No other point moves.", trimmed->triangles_removed,
                  trimmed->removed_mm2));
  ImGui::PopTextWrapPos();
  if (ui::button("Undo cut")) run(context, "import.trim-undo");
  ImGui::SameLine();
  if (ui::button("Other side")) run(context, "import.trim-flip");
  if (ImGui::IsItemHovered()) ui::setTooltip("The last cut keeps this part and removes the rest.");
  ImGui::SameLine();
  if (ui::button("Whole scan")) run(context, "import.trim-reset");
}

void drawTrimLine(const AppContext& context, double pixels) {
  const TrimDrawing& drawing = context.bench.imports->drawing;
  if (!drawing.isOn() || !context.bench.imports->plan()) return;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  std::vector<ImVec2> line;
  for (const Pixel& p : drawing.points())
    line.push_back({static_cast<float>(p[0] / pixels), static_cast<float>(p[1] / pixels)});
  const ImU32 colour = IM_COL32(214, 60, 40, 255);
  const bool is_closed = drawing.what() == What::kLasso && line.size() > 2;
  list.AddPolyline(line.data(), static_cast<int>(line.size()), colour, is_closed ? ImDrawFlags_Closed : 0, scaled(2));

  // The hint, at the lower edge of the free picture.
  const FrameArea free = frameLayout(context).free;
  const std::string hint = drawing.hint();
  const ImVec2 size = ui::textSize(ui::asItIs(hint));
  const ImVec2 at{free.left + 0.5f * (free.width() - size.x), free.bottom - size.y - scaled(16)};
  const float edge = scaled(6);
  ImVec4 back = ImGui::GetStyleColorVec4(ImGuiCol_WindowBg);
  back.w = 0.85f;
  list.AddRectFilled({at.x - edge, at.y - edge}, {at.x + size.x + edge, at.y + size.y + edge},
                     ImGui::ColorConvertFloat4ToU32(back), scaled(4));
  ui::addText(list, at, styleColours().guide_text, ui::asItIs(hint));
}

}  // namespace kerf
