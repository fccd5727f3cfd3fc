#include "ui/window/panels/help_panel.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <string>

#include "geometry/base/version.h"
#include "ui/app/base/language.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kTourWidth = 330, kDialogWidth = 520, kDialogHeight = 420;

struct TourStep {
  const char* title;
  std::array<const char*, 4> lines;
};
constexpr std::array<TourStep, 4> kTour = {{
    {"Choose a tool", {"A click in the list holds it. A star keeps it at the top."}},
    {"Cut",
     {"Left button on the object: cut. Hold still to cut down to the depth limit.",
      "Shift: double push. Wheel while cutting: change the depth limit.",
      "Alt and drag: tilt the tool. Ctrl while cutting: move along its axis.",
      "Space: foot pedal. Arrows, Home and End with it: small steps."}},
    {"Look around",
     {"Right button: turn. Middle button: move. Wheel: zoom.", "Right click: menu at the cursor.",
      "F: whole object. Keys 1 to 7: its sides."}},
    {"Undo and export", {"Ctrl+Z takes back a step, Ctrl+E exports the result.", "Help > Keys lists all keys."}},
}};

void drawLines(const TourStep& step) {
  ImGui::PushTextWrapPos(0);
  for (const char* const line : step.lines)
    if (line) ui::text(line);
  ImGui::PopTextWrapPos();
}

void endTour(AppContext& context, std::size_t& step) {
  step = 0;
  if (const auto done = runAppCommand(context, "view.hints", std::vector<std::string>{"off"}); !done)
    context.bench.notices->complain(done.error());
}

// The window of a switch.   @return  false: it is off.
bool beginDialog(AppContext& context, const char* title, const char* panel, float height) {
  if (!context.panels[panel]) return false;
  placeDialog(context, scaled(kDialogWidth), scaled(height));
  ui::begin(title, &context.panels[panel],
            ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                ImGuiWindowFlags_NoSavedSettings);
  return true;
}

}  // namespace

void drawLeftButton(AppContext& context) {
  const bool turns = context.settings->values.left_turns;
  const auto choose = [&](const char* label, bool is_chosen, const char* word) {
    if (ui::radioButton(label, is_chosen) && !is_chosen)
      runIfEnabled(context, "settings.left-button", std::vector<std::string>{word});
  };
  ImGui::PushTextWrapPos(0);
  ui::textColored(styleColours().quiet, "Left mouse button:");
  ImGui::PopTextWrapPos();
  choose("leads the tool", !turns, "tool");
  choose("turns view (E: tool)", turns, "turn");
}

void drawTour(AppContext& context, std::size_t& step) {
  if (!context.settings || context.settings->values.are_hints_dismissed) return;
  const FrameArea free = frameLayout(context).free;
  // Leaves a quarter of the width for the scale bar.
  const float width = std::min(scaled(kTourWidth), 0.7f * free.width() - scaled(16));
  ImGui::SetNextWindowPos({free.left + scaled(8), free.bottom - scaled(8)}, ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowSize({width, 0}, ImGuiCond_Always);
  ui::begin("##tour", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  step = std::min(step, kTour.size() - 1);
  const TourStep& now = kTour[step];
  ImGui::PushTextWrapPos(0);
  ui::textColored(styleColours().accent,
                  ui::asItIs(phrase("{} of {}: {}", step + 1, kTour.size(), shownText(now.title))));
  ImGui::PopTextWrapPos();
  drawLines(now);
  if (step == 0) drawLeftButton(context);
  const bool is_last = step + 1 == kTour.size();
  if (is_last ? ui::button("Got it###next-step") : ui::button("Next###next-step"))
    is_last ? endTour(context, step) : void(++step);
  ImGui::SameLine();
  if (!is_last && ui::button("Skip")) endTour(context, step);
  ImGui::End();
}

void drawKeys(AppContext& context) {
  if (!beginDialog(context, "Keys", "keys", kDialogHeight)) return;
  std::string_view menu;
  for (const char* const heading : {"File", "Edit", "Tool", "Piece", "Saw", "Device", "Replay", "View", "Help"})
    for (const AppCommand* const command : commandsOfMenu(heading)) {
      if (command->key.empty()) continue;
      if (menu != heading) kerf::heading(heading);
      menu = heading;
      ui::text(ui::asItIs(shownKey(command->key)));
      ui::sameLineAt(scaled(130));
      ui::text(command->label);
    }
  kerf::heading("Mouse");
  drawLines(kTour[1]);
  drawLines(kTour[2]);
  ImGui::End();
}

void drawMessages(AppContext& context) {
  if (!beginDialog(context, "Messages", "messages", kDialogHeight)) return;
  const auto& notices = context.bench.notices->list();
  if (notices.empty()) ui::textColored(styleColours().quiet, "No messages.");
  ImGui::PushTextWrapPos(0);
  for (const Notice& notice : notices)
    notice.is_error ? ui::textColored(styleColours().warning, notice.text) : ui::text(notice.text);
  ImGui::PopTextWrapPos();
  ImGui::End();
}

void drawAbout(AppContext& context) {
  if (!beginDialog(context, "About Kerf", "about", 0)) return;
  ImGui::PushTextWrapPos(0);
  ui::text(phrase("Kerf {}", kVersion));
  ui::text("Cuts teeth, jaws and models of them, and exports the result for a printer.");
  ui::textColored(styleColours().warning, "Training and lab tool, not a medical device");
  ui::textColored(styleColours().quiet, "Licence: GNU General Public License, version 3. No warranty.");
  ImGui::PopTextWrapPos();
  ImGui::End();
}

}  // namespace kerf
