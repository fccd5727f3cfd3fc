#include "ui/window/style.h"

#include <string>

namespace kerf {
namespace {

StyleColours colours;
float scale_now = 1;

bool buttonWithKey(const char* label, const char* key, float width) {
  const std::string text = *key ? std::string(label) + "   " + key : std::string(label);
  return ImGui::Button((text + "###" + label).c_str(), {width, scaled(34)});
}

}  // namespace

const StyleColours& styleColours() { return colours; }

float scaled(float units) { return units * scale_now; }

void applyStyle(float scale) {
  scale_now = scale;
  ImGuiStyle style;
  ImGui::StyleColorsLight(&style);
  style.WindowRounding = 6;
  style.FrameRounding = 4;
  style.GrabRounding = 4;
  style.PopupRounding = 6;
  style.WindowBorderSize = 1;
  style.WindowPadding = {12, 10};
  style.ItemSpacing = {8, 6};
  style.Colors[ImGuiCol_WindowBg] = {0.985f, 0.985f, 0.99f, 0.94f};
  style.Colors[ImGuiCol_TitleBgActive] = style.Colors[ImGuiCol_TitleBg] = {0.90f, 0.92f, 0.95f, 1};
  style.Colors[ImGuiCol_MenuBarBg] = {0.945f, 0.955f, 0.97f, 1};
  style.Colors[ImGuiCol_Button] = {0.87f, 0.91f, 0.95f, 1};
  style.Colors[ImGuiCol_Header] = {0.78f, 0.87f, 0.95f, 1};
  style.Colors[ImGuiCol_FrameBg] = {0.885f, 0.91f, 0.945f, 1};
  style.Colors[ImGuiCol_ButtonHovered] = style.Colors[ImGuiCol_HeaderHovered] = {0.70f, 0.82f, 0.93f, 1};
  style.Colors[ImGuiCol_ButtonActive] = style.Colors[ImGuiCol_HeaderActive] = {0.60f, 0.76f, 0.90f, 1};
  style.Colors[ImGuiCol_PlotHistogram] = style.Colors[ImGuiCol_SliderGrab] = {0.22f, 0.52f, 0.74f, 1};
  style.Colors[ImGuiCol_CheckMark] = {0.10f, 0.42f, 0.62f, 1};
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;

  colours.warning = {0.76f, 0.30f, 0.10f, 1};
  colours.good = {0.13f, 0.52f, 0.30f, 1};
  colours.quiet = {0.38f, 0.41f, 0.46f, 1};
  colours.accent = {0.10f, 0.42f, 0.62f, 1};
  colours.strong = {0.12f, 0.45f, 0.66f, 1};
  colours.strong_hovered = {0.16f, 0.53f, 0.77f, 1};
  colours.strong_text = {1, 1, 1, 1};
  colours.guide = IM_COL32(40, 66, 92, 150);
  colours.guide_text = IM_COL32(28, 46, 66, 255);
}

bool strongButton(const char* label, const char* key, float width) {
  ImGui::PushStyleColor(ImGuiCol_Button, colours.strong);
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, colours.strong_hovered);
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, colours.strong_hovered);
  ImGui::PushStyleColor(ImGuiCol_Text, colours.strong_text);
  const bool is_pressed = buttonWithKey(label, key, width);
  ImGui::PopStyleColor(4);
  return is_pressed;
}

bool plainButton(const char* label, const char* key, float width) { return buttonWithKey(label, key, width); }

void heading(const char* text) {
  ImGui::Dummy({0, scaled(4)});
  ImGui::TextColored(colours.accent, "%s", text);
}

}  // namespace kerf
