#include "ui/window/panels/die_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <string>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/sawing.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kNumberAt = 110;  // before scaled()

void runDie(AppContext& context, const char* id, const std::vector<std::string>& words = {}) {
  if (const auto done = runAppCommand(context, id, words); !done) context.bench.notices->complain(done.error());
}

// A typed number with its unit; set when the field is left.
void numberField(AppContext& context, const char* label, const char* name, double value, const char* format) {
  ImGui::PushID(name);
  ImGui::AlignTextToFramePadding();
  ui::text(label);
  ui::sameLineAt(scaled(kNumberAt));
  ImGui::PushItemWidth(-1);
  auto typed = static_cast<float>(value);
  ui::inputFloat("##number", &typed, format);
  if (ImGui::IsItemDeactivatedAfterEdit()) runDie(context, "plane.die-set", {name, fmt::format("{:.6g}", typed)});
  ImGui::PopItemWidth();
  ImGui::PopID();
}

}  // namespace

void drawDie(AppContext& context) {
  DieMaking& die = context.bench.saw->die;
  if (ui::button("Die: click a tooth", {-1, 0})) runDie(context, "plane.die");
  if (ImGui::IsItemHovered()) ui::setTooltip("Plans a removable die with a pin hole (Shift+D)");
  if (!die.isPlanned()) return;

  const DieChoice choice = die.choice();
  numberField(context, "Base height", "base", choice.base_mm, "%.1f mm");
  numberField(context, "Taper", "taper", choice.taper_deg, "%.1f degrees");
  numberField(context, "Gap", "kerf", choice.kerf_mm, "%.2f mm");
  numberField(context, "Pin diameter", "pin", choice.pin_mm, "%.1f mm");
  if (choice.pin_mm > 0) numberField(context, "Pin depth", "pin-depth", choice.pin_depth_mm, "%.1f mm");
  bool is_tapered = choice.has_four_sides;
  if (ui::checkbox("Four tapered sides", &is_tapered))
    runDie(context, "plane.die-set", {"sides", is_tapered ? "4" : "2"});
  if (ImGui::IsItemHovered()) ui::setTooltip("Off: the die is as wide as the arch");
  if (!die.pin()) ui::textColored(styleColours().warning, shownText("No room for the pin hole"));
  if (strongButton("Cut die", "", -1)) runDie(context, "plane.die-cut");
  if (ImGui::IsItemHovered()) ui::setTooltip("Shift+Enter");
}

}  // namespace kerf
