#include "ui/window/gl/theme.h"

#include <algorithm>
#include <string>

#include "ui/app/base/language.h"

namespace kerf {
namespace {

StyleColours colours;
float scale_now = 1;

bool buttonWithKey(const ui::Words& label, const ui::Words& key, float width) {
  std::string text = label.label();
  if (const std::string shown = shownKey(key.shown()); !shown.empty())
    text.insert(std::min(text.find("###"), text.size()), "   " + shown);
  return ui::button(ui::asItIs(text), {width, scaled(34)});
}

}  // namespace

const StyleColours& styleColours() { return colours; }

float scaled(float units) { return units * scale_now; }

namespace {

void makeLight(ImGuiStyle& style) {
  ImGui::StyleColorsLight(&style);
  ImVec4* const c = style.Colors;
  c[ImGuiCol_WindowBg] = {0.985f, 0.985f, 0.99f, 0.94f};
  c[ImGuiCol_TitleBgActive] = c[ImGuiCol_TitleBg] = {0.90f, 0.92f, 0.95f, 1};
  c[ImGuiCol_MenuBarBg] = {0.945f, 0.955f, 0.97f, 1};
  c[ImGuiCol_Button] = {0.87f, 0.91f, 0.95f, 1};
  c[ImGuiCol_Header] = {0.78f, 0.87f, 0.95f, 1};
  c[ImGuiCol_FrameBg] = {0.885f, 0.91f, 0.945f, 1};
  c[ImGuiCol_ButtonHovered] = c[ImGuiCol_HeaderHovered] = {0.70f, 0.82f, 0.93f, 1};
  c[ImGuiCol_ButtonActive] = c[ImGuiCol_HeaderActive] = {0.60f, 0.76f, 0.90f, 1};
  c[ImGuiCol_PlotHistogram] = c[ImGuiCol_SliderGrab] = {0.22f, 0.52f, 0.74f, 1};
  c[ImGuiCol_CheckMark] = {0.10f, 0.42f, 0.62f, 1};

  colours.warning = {0.76f, 0.30f, 0.10f, 1};
  colours.good = {0.13f, 0.52f, 0.30f, 1};
  colours.quiet = {0.38f, 0.41f, 0.46f, 1};
  colours.accent = {0.10f, 0.42f, 0.62f, 1};
  colours.strong = {0.12f, 0.45f, 0.66f, 1};
  colours.strong_hovered = {0.16f, 0.53f, 0.77f, 1};
  colours.strong_text = {1, 1, 1, 1};
  colours.guide = IM_COL32(40, 66, 92, 150);
  colours.guide_text = IM_COL32(28, 46, 66, 255);
  colours.background_middle = {0.80f, 0.835f, 0.87f};
  colours.background_edge = {0.49f, 0.55f, 0.62f};
}

void makeDark(ImGuiStyle& style) {
  ImGui::StyleColorsDark(&style);
  ImVec4* const c = style.Colors;
  c[ImGuiCol_Text] = {0.90f, 0.92f, 0.94f, 1};
  c[ImGuiCol_WindowBg] = {0.115f, 0.125f, 0.14f, 0.95f};
  c[ImGuiCol_PopupBg] = {0.14f, 0.15f, 0.17f, 0.98f};
  c[ImGuiCol_Border] = {0.27f, 0.30f, 0.34f, 1};
  c[ImGuiCol_TitleBgActive] = c[ImGuiCol_TitleBg] = {0.17f, 0.19f, 0.215f, 1};
  c[ImGuiCol_MenuBarBg] = {0.14f, 0.15f, 0.17f, 1};
  c[ImGuiCol_Button] = {0.22f, 0.25f, 0.29f, 1};
  c[ImGuiCol_Header] = {0.19f, 0.33f, 0.45f, 1};
  c[ImGuiCol_FrameBg] = {0.195f, 0.215f, 0.245f, 1};
  c[ImGuiCol_FrameBgHovered] = {0.24f, 0.28f, 0.32f, 1};
  c[ImGuiCol_FrameBgActive] = {0.27f, 0.32f, 0.37f, 1};
  c[ImGuiCol_ButtonHovered] = c[ImGuiCol_HeaderHovered] = {0.25f, 0.38f, 0.49f, 1};
  c[ImGuiCol_ButtonActive] = c[ImGuiCol_HeaderActive] = {0.29f, 0.46f, 0.60f, 1};
  c[ImGuiCol_PlotHistogram] = c[ImGuiCol_SliderGrab] = {0.36f, 0.66f, 0.88f, 1};
  c[ImGuiCol_SliderGrabActive] = {0.46f, 0.74f, 0.94f, 1};
  c[ImGuiCol_CheckMark] = {0.46f, 0.74f, 0.94f, 1};
  c[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, 0.45f};

  colours.warning = {0.98f, 0.62f, 0.36f, 1};
  colours.good = {0.45f, 0.80f, 0.56f, 1};
  colours.quiet = {0.62f, 0.66f, 0.71f, 1};
  colours.accent = {0.47f, 0.75f, 0.95f, 1};
  colours.strong = {0.13f, 0.47f, 0.69f, 1};
  colours.strong_hovered = {0.18f, 0.56f, 0.80f, 1};
  colours.strong_text = {1, 1, 1, 1};
  colours.guide = IM_COL32(160, 190, 215, 130);
  colours.guide_text = IM_COL32(222, 232, 242, 255);
  colours.background_middle = {0.27f, 0.295f, 0.325f};
  colours.background_edge = {0.085f, 0.095f, 0.11f};
}

}  // namespace

void applyStyle(Theme theme, float scale) {
  scale_now = scale;
  ImGuiStyle style;
  theme == Theme::kDark ? makeDark(style) : makeLight(style);
  style.WindowRounding = 6;
  style.FrameRounding = 4;
  style.GrabRounding = 4;
  style.PopupRounding = 6;
  style.WindowBorderSize = 1;
  style.WindowPadding = {12, 10};
  style.ItemSpacing = {8, 6};
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;
}

bool strongButton(const ui::Words& label, const ui::Words& key, float width) {
  ImGui::PushStyleColor(ImGuiCol_Button, colours.strong);
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, colours.strong_hovered);
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, colours.strong_hovered);
  ImGui::PushStyleColor(ImGuiCol_Text, colours.strong_text);
  const bool is_pressed = buttonWithKey(label, key, width);
  ImGui::PopStyleColor(4);
  return is_pressed;
}

bool plainButton(const ui::Words& label, const ui::Words& key, float width) { return buttonWithKey(label, key, width); }

void heading(const ui::Words& text) {
  ImGui::Dummy({0, scaled(4)});
  ui::textColored(colours.accent, text);
}

}  // namespace kerf
