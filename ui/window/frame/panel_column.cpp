#include "ui/window/frame/panel_column.h"

#include <imgui.h>

#include <algorithm>

#include "ui/window/frame/timeline_panel.h"
#include "ui/window/gl/theme.h"

namespace kerf {
namespace {

constexpr float kLeastHeight = 110, kColumnGap = 8;

float firstTop() { return ImGui::GetFrameHeight() + kColumnGap; }

}  // namespace

PanelColumn::PanelColumn(const AppContext& context)
    : left_(ImGui::GetIO().DisplaySize.x - scaled(kPanelWidth) - kColumnGap),
      top_(firstTop()),
      end_(ImGui::GetIO().DisplaySize.y - timelineHeight(context) - kColumnGap) {}

void PanelColumn::place() {
  const float width = scaled(kPanelWidth), least = scaled(kLeastHeight);
  if (top_ > firstTop() && top_ + least > end_) {
    left_ -= width + kColumnGap;
    top_ = firstTop();
  }
  ImGui::SetNextWindowPos({left_, top_}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({width, 0}, ImGuiCond_Always);
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, std::max(end_ - top_, least)});
}

void PanelColumn::take() { top_ = ImGui::GetWindowPos().y + ImGui::GetWindowSize().y + kColumnGap; }

}  // namespace kerf
