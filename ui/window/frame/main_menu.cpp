#include "ui/window/frame/main_menu.h"

#include <fmt/format.h>
#include <imgui.h>

#include <string>
#include <string_view>

#include "ui/app/base/language.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {

void drawMainMenu(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file) {
  if (!ImGui::BeginMainMenuBar()) return;
  for (const char* const heading : {"File", "Edit", "Tool", "Piece", "Saw", "Device", "Replay", "View"}) {
    if (!ui::beginMenu(heading)) continue;
    std::string_view section;
    for (const AppCommand* const row : commandsOfMenu(heading)) {
      const AppCommand& command = *row;
      if (!section.empty() && section != command.menu) ImGui::Separator();
      section = command.menu;
      const std::string label = fmt::format("{}###{}", command.label, command.id);
      if (!ui::menuItem(label, ui::asItIs(shownKey(command.key)), command.is_enabled(context))) continue;
      asksForFile(command) ? ask_for_file(command) : runIfEnabled(context, command.id);
    }
    ImGui::EndMenu();
  }
  const std::string right = "Training and lab tool, not a medical device";
  ImGui::SameLine(ImGui::GetWindowWidth() - ui::textSize(right).x - 16);
  ui::textColored(styleColours().quiet, right);
  ImGui::EndMainMenuBar();
}

}  // namespace kerf
