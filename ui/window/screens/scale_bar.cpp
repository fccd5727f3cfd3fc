#include "ui/window/screens/scale_bar.h"

#include "ui/app/base/language.h"
#include "ui/window/gl/widgets.h"

#include <fmt/format.h>

namespace kerf {

void drawScaleBarAt(const ImVec2& at, const Camera& camera, int width, int height, double pixels_per_unit, ImU32 ink) {
  const double mm_per_pixel = camera.mmPerPixel(height), length = scaleBarLength(mm_per_pixel, width);
  const float left = at.x - static_cast<float>(length / mm_per_pixel / pixels_per_unit);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddLine({left, at.y}, at, ink, 2);
  list.AddLine({left, at.y - 5}, {left, at.y + 5}, ink, 2);
  list.AddLine({at.x, at.y - 5}, {at.x, at.y + 5}, ink, 2);

  const std::string text = shownNumbers("{:g} mm", length) + shownText(camera.isPerspective() ? " at the focus" : "");
  const ImVec2 size = ui::textSize(text);
  ui::addText(list, {0.5f * (left + at.x - size.x), at.y - 5 - size.y}, ink, text);
}

}  // namespace kerf
