#include "ui/window/screens/debrief.h"

#include <imgui.h>

#include <algorithm>
#include <string>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/import/session_list.h"
#include "ui/app/workbench/sessions.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {

void drawDebrief(AppContext& context) {
  Sessions& sessions = *context.bench.sessions;
  if (!sessions.debrief() || context.bench.jobs->running()) return;
  const Debrief ended = *sessions.debrief();  // a button below ends it
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos({0.5f * io.DisplaySize.x, 0.5f * io.DisplaySize.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(scaled(520), io.DisplaySize.x - scaled(24)), 0}, ImGuiCond_Always);
  ImGui::SetNextWindowBgAlpha(1);
  bool stays = true;
  ui::begin("Session ended", &stays,
            ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                ImGuiWindowFlags_NoSavedSettings);
  ImGui::PushTextWrapPos(0);
  ui::text(ui::asItIs(sessionTitle(ended.folder)));
  ui::text(ui::asItIs(ended.text));
  ui::textColored(styleColours().quiet, "It is saved: the first screen and File > Sessions have it.");
  ImGui::PopTextWrapPos();
  ImGui::Dummy({0, scaled(4)});
  const float width = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  const std::vector<std::string> words{ended.folder.string()};
  if (strongButton("Watch again", "", width)) {
    sessions.endDebrief();
    runIfEnabled(context, "replay.open", words);
  }
  ImGui::SameLine();
  if (plainButton("Continue", "", width)) {
    sessions.endDebrief();
    runIfEnabled(context, "file.open", words);
  }
  ImGui::SameLine();
  if (plainButton("Close", "Esc", -1)) stays = false;
  ImGui::End();
  if (!stays) sessions.endDebrief();
}

bool closeDebrief(AppContext& context) {
  if (!context.bench.sessions->debrief() || context.bench.document->isShown()) return false;
  context.bench.sessions->endDebrief();
  return true;
}

}  // namespace kerf
