#include "ui/window/frame/frame_layout.h"

#include <imgui.h>

#include <algorithm>

#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/imports.h"
#include "ui/window/frame/timeline_panel.h"
#include "ui/window/gl/theme.h"

namespace kerf {
namespace {

constexpr float kLeastFree = 240, kLeastColumn = 220, kEdgeWidth = 6, kDialogGap = 8;  // before scaled()

// A handle as high as the column.
bool dragEdge(const char* id, const FrameArea& column, float edge, float& width, float towards) {
  ImGui::SetNextWindowPos({edge - 0.5f * scaled(kEdgeWidth), column.top});
  ImGui::SetNextWindowSize({scaled(kEdgeWidth), column.height()});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  ui::begin(id, nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBackground |
                ImGuiWindowFlags_NoSavedSettings);
  ImGui::PopStyleVar(2);
  ImGui::InvisibleButton("##edge", {scaled(kEdgeWidth), std::max(column.height(), 1.0f)});
  if (ImGui::IsItemHovered() || ImGui::IsItemActive()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  if (ImGui::IsItemActive()) width += towards * ImGui::GetIO().MouseDelta.x / scaled(1);
  const bool is_over = ImGui::IsItemDeactivated();
  ImGui::End();
  return is_over;
}

}  // namespace

Screen screenOf(const Workbench& bench) {
  if (bench.imports->isImporting()) return Screen::kImport;
  if (bench.document->watched()) return Screen::kReplay;
  return bench.document->isOpen() ? Screen::kCut : Screen::kFirst;
}

FrameLayout layoutOf(Screen screen, const FrameSizes& s) {
  FrameLayout out;
  float left = screen == Screen::kCut ? s.left : 0;
  float right = screen == Screen::kCut || screen == Screen::kReplay ? s.right
                : screen == Screen::kImport                         ? std::min(s.import, s.width)
                                                                    : 0;
  const float most = s.width - s.scale * kLeastFree, least = s.scale * kLeastColumn;
  if (left > 0 && left + right > most) {
    left = right = std::max(least, 0.5f * most);
    out.is_single = left + right > most;
    if (out.is_single) {
      left = 0;
      right = std::min(s.right, std::max(least, most));
    }
  }

  const float bottom = s.height - s.strip;
  const bool is_below_all = screen == Screen::kReplay;  // its bar is as wide as the window
  const float end = is_below_all ? bottom : s.height;
  out.left = {0, s.menu, left, end};
  out.right = {s.width - right, s.menu, s.width, end};
  out.strip = {is_below_all ? 0 : left, bottom, is_below_all ? s.width : s.width - right, s.height};
  out.free = {left, s.menu, s.width - right, bottom};
  return out;
}

FrameLayout frameLayout(const AppContext& context) {
  const ImGuiIO& io = ImGui::GetIO();
  const Settings kept = context.settings ? context.settings->values : Settings{};
  return layoutOf(screenOf(context.bench), {.width = io.DisplaySize.x,
                                            .height = io.DisplaySize.y,
                                            .menu = ImGui::GetFrameHeight(),
                                            .strip = timelineHeight(context),
                                            .left = scaled(static_cast<float>(kept.left_width)),
                                            .right = scaled(static_cast<float>(kept.right_width)),
                                            .import = scaled(kImportPanelWidth),
                                            .scale = scaled(1)});
}

void drawColumnEdges(AppContext& context) {
  const FrameLayout layout = frameLayout(context);
  if (!context.settings || screenOf(context.bench) == Screen::kImport) return;
  Settings& kept = context.settings->values;
  const auto drag = [&](const char* id, const FrameArea& column, float edge, double& width, float towards) {
    if (column.width() <= 0) return;
    auto now = static_cast<float>(width);
    const bool is_over = dragEdge(id, column, edge, now, towards);
    width = std::clamp(static_cast<double>(now), Settings::kNarrowestColumn, Settings::kWidestColumn);
    if (!is_over) return;
    if (const auto done = context.settings->save(); !done) context.bench.notices->complain(done.error());
  };
  drag("##left-edge", layout.left, layout.left.right, kept.left_width, 1);
  drag("##right-edge", layout.right, layout.right.left, kept.right_width, -1);
}

void placeDialog(const AppContext& context, float width, float height) {
  const ImGuiIO& io = ImGui::GetIO();
  FrameArea at = frameLayout(context).free;
  if (at.width() < width + 2 * scaled(kDialogGap)) {
    at.left = 0;
    at.right = io.DisplaySize.x;
  }
  const float most = at.height() - 2 * scaled(kDialogGap);
  ImGui::SetNextWindowPos({at.middle(), 0.5f * (at.top + at.bottom)}, ImGuiCond_Always, {0.5f, 0.5f});
  const float wide = std::min(width, at.width() - 2 * scaled(kDialogGap));
  ImGui::SetNextWindowSize({wide, std::min(height, most)}, ImGuiCond_Always);
  ImGui::SetNextWindowSizeConstraints({wide, 0}, {wide, most});
}

ViewMargins marginsOf(const AppContext& context, double pixels) {
  const ImGuiIO& io = ImGui::GetIO();
  const FrameArea free = frameLayout(context).free;
  const auto pixel = [&](float units) { return static_cast<int>(pixels * static_cast<double>(units)); };
  return {.left = pixel(free.left),
          .top = pixel(free.top),
          .right = pixel(io.DisplaySize.x - free.right),
          .bottom = pixel(io.DisplaySize.y - free.bottom)};
}

}  // namespace kerf
