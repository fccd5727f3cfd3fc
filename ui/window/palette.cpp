#include "ui/window/palette.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "ui/window/style.h"

namespace kerf {
namespace {

// As much of a text as fits, with dots if that is not all.
std::string shortened(std::string_view text, float width) {
  std::string out(text);
  if (ImGui::CalcTextSize(out.c_str()).x <= width) return out;
  while (!out.empty() && ImGui::CalcTextSize((out + "...").c_str()).x > width) out.pop_back();
  return out + "...";
}

constexpr std::size_t kRows = 12;

void drawLine(const CommandPalette& palette) {
  const AppCommand* const asked = palette.asked();
  const StyleColours& colours = styleColours();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, height = scaled(34), pad = scaled(10);
  list.AddRectFilled(at, {at.x + width, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg), scaled(4));

  float x = at.x + pad;
  const float y = at.y + 0.5f * (height - ImGui::GetTextLineHeight());
  const auto write = [&](const std::string& text, ImU32 colour) {
    list.AddText({x, y}, colour, text.c_str());
    x += ImGui::CalcTextSize(text.c_str()).x;
  };
  const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text), quiet = ImGui::ColorConvertFloat4ToU32(colours.quiet);
  if (asked) write(fmt::format("{}  ", asked->id), ImGui::ColorConvertFloat4ToU32(colours.accent));
  write(palette.text(), ink);
  list.AddLine({x + 1, y - 1}, {x + 1, y + ImGui::GetTextLineHeight() + 1}, ink, scaled(1.5f));
  if (palette.text().empty()) {
    x += pad;
    write(asked ? std::string(asked->parameters) : "What do you want to do?", quiet);
  }
  ImGui::Dummy({width, height});
}

}  // namespace

const AppCommand* drawPalette(AppContext& context, CommandPalette& palette) {
  if (!palette.isShown()) return nullptr;
  const StyleColours& colours = styleColours();
  const ImGuiIO& io = ImGui::GetIO();
  const AppCommand* wants_path = nullptr;
  ImGui::SetNextWindowPos({0.5f * io.DisplaySize.x, ImGui::GetFrameHeight() + scaled(40)}, ImGuiCond_Always, {0.5f, 0});
  ImGui::SetNextWindowSize({std::min(scaled(620), io.DisplaySize.x - scaled(24)), 0}, ImGuiCond_Always);
  ImGui::SetNextWindowFocus();
  ImGui::Begin("##palette", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  drawLine(palette);

  if (!palette.error().empty()) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored(colours.warning, "%s", palette.error().c_str());
    ImGui::PopTextWrapPos();
  }
  if (const AppCommand* const asked = palette.asked()) {
    ImGui::TextColored(colours.quiet, "%s", std::string(asked->description).c_str());
  } else {
    // The rows about the selected one.
    const std::size_t count = palette.found().size();
    const std::size_t first = palette.selected() < kRows ? 0 : palette.selected() - kRows + 1;
    if (count == 0) ImGui::TextColored(colours.quiet, "No command has these words.");
    for (std::size_t n = first; n < std::min(count, first + kRows); ++n) {
      const AppCommand& command = *palette.found()[n];
      const bool is_enabled = command.is_enabled(context);
      const std::string right = command.key.empty() ? std::string(command.id) : std::string(command.key);
      const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(right.c_str()).x - scaled(16);
      const std::string name = shortened(command.label.empty() ? command.description : command.label, room);
      ImGui::PushID(static_cast<int>(n));
      if (!is_enabled) ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
      if (ImGui::Selectable(name.c_str(), n == palette.selected())) {
        palette.select(n);
        wants_path = palette.accept(context);
      }
      if (!is_enabled) ImGui::PopStyleColor();
      ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - ImGui::CalcTextSize(right.c_str()).x);
      ImGui::TextColored(colours.quiet, "%s", right.c_str());
      ImGui::PopID();
      if (!palette.isShown() || palette.asked()) break;  // the list is another one now
    }
  }
  ImGui::End();
  return wants_path;
}

}  // namespace kerf
