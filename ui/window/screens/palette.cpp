#include "ui/window/screens/palette.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "ui/app/base/language.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

// The text as far as it fits, with dots if cut. Never cuts a UTF-8 character in two.
std::string shortened(std::string_view text, float width) {
  std::string out(text);
  if (ui::textSize(ui::asItIs(out)).x <= width) return out;
  while (!out.empty() && ui::textSize(ui::asItIs(out + "...")).x > width) {
    while (out.size() > 1 && (static_cast<unsigned char>(out.back()) & 0xC0) == 0x80) out.pop_back();
    out.pop_back();
  }
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
    ui::addText(list, {x, y}, colour, ui::asItIs(text));
    x += ui::textSize(ui::asItIs(text)).x;
  };
  const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text), quiet = ImGui::ColorConvertFloat4ToU32(colours.quiet);
  if (asked) write(fmt::format("{}  ", asked->id), ImGui::ColorConvertFloat4ToU32(colours.accent));
  write(palette.text(), ink);
  list.AddLine({x + 1, y - 1}, {x + 1, y + ImGui::GetTextLineHeight() + 1}, ink, scaled(1.5f));
  if (palette.text().empty()) {
    x += pad;
    write(asked ? std::string(asked->parameters) : shownText("What do you want to do?"), quiet);
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
  ui::begin("##palette", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  drawLine(palette);

  if (!palette.error().empty()) {
    ImGui::PushTextWrapPos(0);
    ui::textColored(colours.warning, palette.error());
    ImGui::PopTextWrapPos();
  }
  if (const AppCommand* const asked = palette.asked()) {
    ui::textColored(colours.quiet, asked->description);
  } else {
    // The rows about the selected one.
    const std::size_t count = palette.found().size();
    const std::size_t first = palette.selected() < kRows ? 0 : palette.selected() - kRows + 1;
    if (count == 0) ui::textColored(colours.quiet, "No command matches.");
    for (std::size_t n = first; n < std::min(count, first + kRows); ++n) {
      const AppCommand& command = *palette.found()[n];
      const bool is_enabled = command.is_enabled(context);
      const std::string key = shownKey(command.key);
      const ui::Words right = ui::asItIs(key.empty() ? command.id : key);
      const float room = ImGui::GetContentRegionAvail().x - ui::textSize(right).x - scaled(16);
      const std::string name = shortened(shownText(command.label.empty() ? command.description : command.label), room);
      ImGui::PushID(static_cast<int>(n));
      if (!is_enabled) ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
      if (ui::selectable(ui::asItIs(name), n == palette.selected())) {
        palette.select(n);
        wants_path = palette.accept(context);
      }
      if (!is_enabled) ImGui::PopStyleColor();
      ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - ui::textSize(right).x);
      ui::textColored(colours.quiet, right);
      ImGui::PopID();
      if (!palette.isShown() || palette.asked()) break;  // the list has changed
    }
  }
  ImGui::End();
  return wants_path;
}

}  // namespace kerf
