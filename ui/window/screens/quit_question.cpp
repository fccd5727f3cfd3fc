#include "ui/window/screens/quit_question.h"

#include <imgui.h>

#include "ui/app/commands/quit_commands.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {

void drawQuitQuestion(AppContext& context) {
  constexpr const char* kTitle = "Quit###quit-question";
  const bool is_open = ui::isPopupOpen(kTitle);
  if (!context.is_asking_to_quit && !is_open) return;
  if (!is_open) ui::openPopup(kTitle);
  ImGui::SetNextWindowSize({scaled(460), 0});
  if (!ui::beginPopupModal(kTitle, nullptr, ImGuiWindowFlags_NoResize)) return;

  ImGui::PushTextWrapPos(0);
  ui::text(quit::question(context.bench));
  ImGui::PopTextWrapPos();
  ImGui::Dummy({0, scaled(4)});
  if (strongButton("Export", "Enter", scaled(135))) quit::exportFirst(context);
  ImGui::SameLine();
  if (plainButton("Quit", "Ctrl+Q", scaled(135))) (void)runAppCommand(context, "app.quit");
  ImGui::SameLine();
  if (plainButton("Cancel", "Esc", -1)) (void)runAppCommand(context, "app.stay");
  if (!context.is_asking_to_quit) ImGui::CloseCurrentPopup();  // answered by a key, or just now
  ImGui::EndPopup();
}

bool quitQuestionKey(AppContext& context, bool is_enter) {
  if (!context.is_asking_to_quit) return false;
  if (is_enter)
    quit::exportFirst(context);
  else
    (void)runAppCommand(context, "app.stay");
  return true;
}

}  // namespace kerf
