#include "ui/window/readings.h"

#include <fmt/format.h>
#include <imgui.h>

#include "ui/window/style.h"

namespace kerf {

void reading(const char* name, const std::string& value, const char* unit, bool is_warning) {
  ImGui::TextColored(styleColours().quiet, "%s", name);
  ImGui::SameLine(scaled(118));
  is_warning ? ImGui::TextColored(styleColours().warning, "%s %s", value.c_str(), unit)
             : ImGui::Text("%s %s", value.c_str(), unit);
}

// Limits: bone that dies after a minute, a pulp that not always recovers, a surface that boils.
void drawHeat(const Workbench& bench) {
  const HeatReport& heat = bench.report().heat;
  if (!heat.is_known) return reading("Temperature", "-", "C");
  const Material under = bench.report().output.material;
  const bool is_bone = under == Material::kCortical || under == Material::kCancellous;
  const double limit = kBodyCelsius + (is_bone ? kBoneLimitRise : HeatSettings{}.boiling_rise);
  reading("Temperature", fmt::format("{:.0f}", heat.surface), "C", heat.surface >= limit);

  for (const Structures::Structure& structure : bench.structures()->all()) {
    const bool is_pulp = structure.material == Material::kPulp;
    const double rise = is_pulp ? heat.pulp_rise : heat.nerve_rise;
    const std::string name = "  of " + bench.nameOf(structure.material);
    reading(name.c_str(), fmt::format("{:.1f}", kBodyCelsius + rise), "C",
            rise >= (is_pulp ? kPulpLimitRise : kBoneLimitRise));
  }
}

}  // namespace kerf
