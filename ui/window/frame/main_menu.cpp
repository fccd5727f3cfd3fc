#include "ui/window/frame/main_menu.h"

#include <fmt/format.h>
#include <imgui.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/settings/settings.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

// ---- Tools: drawn in a square of side 1

using Stroke = std::vector<ImVec2>;  // a line through points

std::vector<Stroke> undoIcon() {
  Stroke arc;
  for (int n = 0; n <= 10; ++n) {
    const float angle = 3.14159f * (1.15f - 0.135f * static_cast<float>(n));
    arc.push_back({0.52f + 0.33f * std::cos(angle), 0.62f - 0.36f * std::sin(angle)});
  }
  return {arc, {{0.1f, 0.42f}, {0.2f, 0.72f}, {0.46f, 0.6f}}};
}
std::vector<Stroke> redoIcon() {
  std::vector<Stroke> out = undoIcon();
  for (Stroke& stroke : out)
    for (ImVec2& p : stroke) p.x = 1 - p.x;
  return out;
}
std::vector<Stroke> fitIcon() {
  return {{{0.1f, 0.35f}, {0.1f, 0.1f}, {0.35f, 0.1f}},
          {{0.65f, 0.1f}, {0.9f, 0.1f}, {0.9f, 0.35f}},
          {{0.9f, 0.65f}, {0.9f, 0.9f}, {0.65f, 0.9f}},
          {{0.35f, 0.9f}, {0.1f, 0.9f}, {0.1f, 0.65f}},
          {{0.35f, 0.35f}, {0.65f, 0.35f}, {0.65f, 0.65f}, {0.35f, 0.65f}, {0.35f, 0.35f}}};
}
std::vector<Stroke> sectionIcon() {
  return {{{0.5f, 0.02f}, {0.5f, 0.98f}},
          {{0.5f, 0.2f}, {0.88f, 0.2f}, {0.88f, 0.8f}, {0.5f, 0.8f}},
          {{0.5f, 0.5f}, {0.7f, 0.2f}},
          {{0.5f, 0.8f}, {0.88f, 0.25f}}};
}
std::vector<Stroke> measureIcon() {
  return {{{0.08f, 0.6f}, {0.92f, 0.6f}},
          {{0.08f, 0.35f}, {0.08f, 0.85f}},
          {{0.92f, 0.35f}, {0.92f, 0.85f}},
          {{0.36f, 0.48f}, {0.36f, 0.6f}},
          {{0.64f, 0.48f}, {0.64f, 0.6f}}};
}
std::vector<Stroke> exportIcon() {
  return {{{0.3f, 0.45f}, {0.12f, 0.45f}, {0.12f, 0.92f}, {0.88f, 0.92f}, {0.88f, 0.45f}, {0.7f, 0.45f}},
          {{0.5f, 0.72f}, {0.5f, 0.08f}},
          {{0.3f, 0.28f}, {0.5f, 0.08f}, {0.7f, 0.28f}}};
}

struct IconRow {
  const char* command;
  std::vector<Stroke> (*icon)();
};
std::vector<Stroke> toolIcon() {
  return {{{0.86f, 0.06f}, {0.42f, 0.5f}},
          {{0.94f, 0.14f}, {0.5f, 0.58f}},
          {{0.3f, 0.54f}, {0.46f, 0.7f}, {0.2f, 0.9f}, {0.1f, 0.8f}, {0.3f, 0.54f}}};
}
constexpr IconRow kIcons[] = {{"tool.take", toolIcon},    {"edit.undo", undoIcon},       {"edit.redo", redoIcon},
                              {"view.fit", fitIcon},      {"view.section", sectionIcon}, {"measure.point", measureIcon},
                              {"export.show", exportIcon}};

void drawIcon(AppContext& context, const IconRow& row) {
  const AppCommand& command = *findAppCommand(row.command);
  const bool is_enabled = command.is_enabled(context);
  const float side = ImGui::GetFrameHeight(), inset = 0.2f * side;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::PushID(row.command);
  ImGui::BeginDisabled(!is_enabled);
  if (ImGui::InvisibleButton("##icon", {side, side})) runIfEnabled(context, command.id);
  ImGui::EndDisabled();
  ImGui::PopID();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) {
    ui::setTooltip(ui::asItIs(shownText(command.label) + (command.key.empty() ? "" : "  " + shownKey(command.key))));
    list.AddRectFilled(at, {at.x + side, at.y + side}, ImGui::GetColorU32(ImGuiCol_ButtonHovered), scaled(3));
  }
  if (row.icon == toolIcon && context.is_tool_taken)
    list.AddRectFilled(at, {at.x + side, at.y + side}, ImGui::GetColorU32(ImGuiCol_Header), scaled(3));
  const ImU32 ink = ImGui::GetColorU32(is_enabled ? ImGuiCol_Text : ImGuiCol_TextDisabled);
  for (Stroke stroke : row.icon()) {
    for (ImVec2& p : stroke) p = {at.x + inset + (side - 2 * inset) * p.x, at.y + inset + (side - 2 * inset) * p.y};
    list.AddPolyline(stroke.data(), static_cast<int>(stroke.size()), ink, 0, scaled(1.4f));
  }
}

void drawIcons(AppContext& context) {
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {scaled(2), 0});
  ImGui::Dummy({scaled(8), 0});
  for (const IconRow& row : kIcons)
    if ((row.icon != toolIcon || (context.settings && context.settings->values.left_turns)) &&
        ImGui::GetCursorPosX() + ImGui::GetFrameHeight() < ImGui::GetWindowWidth())
      drawIcon(context, row);
  ImGui::PopStyleVar();
}

// If there is room.
void drawPurpose() {
  const std::string text = "Training and lab tool, not a medical device";
  const float at = ImGui::GetWindowWidth() - ui::textSize(text).x - scaled(28);
  if (at < ImGui::GetCursorPosX()) return;
  ImGui::SameLine(at);
  ui::textColored(styleColours().quiet, text);
}

void drawRow(AppContext& context, const AppCommand& command,
             const std::function<void(const AppCommand&)>& ask_for_file) {
  const std::string label = fmt::format("{}###{}", command.label, command.id);
  if (!ui::menuItem(label, ui::asItIs(shownKey(command.key)), command.is_enabled(context))) return;
  asksForFile(command) ? ask_for_file(command) : runIfEnabled(context, command.id);
}

}  // namespace

void drawMainMenu(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file) {
  if (!ImGui::BeginMainMenuBar()) return;
  for (const char* const heading : {"File", "Edit", "Tool", "Piece", "Saw", "Device", "Replay", "View", "Help"}) {
    if (!ui::beginMenu(heading)) continue;
    const std::vector<const AppCommand*> rows = commandsOfMenu(heading);
    std::string_view above;
    for (std::size_t n = 0; n < rows.size();) {
      const std::string_view section = rows[n]->menu, sub = submenuOf(*rows[n]),
                             group = section.substr(0, section.find('>'));
      if (n > 0 && group != above) ImGui::Separator();
      above = group;
      const bool is_open = sub.empty() || ui::beginMenu(sub);
      for (; n < rows.size() && rows[n]->menu == section; ++n)
        if (is_open) drawRow(context, *rows[n], ask_for_file);
      if (!sub.empty() && is_open) ImGui::EndMenu();
    }
    ImGui::EndMenu();
  }
  drawIcons(context);
  drawPurpose();
  ImGui::EndMainMenuBar();
}

void drawContextMenu(AppContext& context, std::optional<std::array<double, 2>>& at) {
  static constexpr const char* kMenu = "###context-menu";
  static std::vector<std::string> place;  // words of the commands' parameters
  if (at) {
    place = wordsOf({(*at)[0], (*at)[1]});
    at.reset();
    ui::openPopup(kMenu);
  }
  if (!ui::beginPopup(kMenu)) return;
  const auto row = [&](const char* id, const std::vector<std::string>& words) {
    const AppCommand& command = *findAppCommand(id);
    const std::string label = fmt::format("{}###{}", command.label, command.id);
    if (ui::menuItem(label, ui::asItIs(shownKey(command.key)), command.is_enabled(context)))
      runIfEnabled(context, id, words);
  };
  row("view.fit", {});
  row("view.section", place);
  row("measure.point", place);
  row("point.copy", place);
  ImGui::Separator();
  row("piece.hide", {});
  row("piece.show-all", {});
  row("piece.put-back", {});
  row("piece.delete", {});
  ImGui::Separator();
  row("edit.undo", {});
  row("export.show", {});
  ImGui::EndPopup();
}

}  // namespace kerf
