#include "ui/window/screens/readings.h"

#include <fmt/format.h>
#include <imgui.h>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"
#include "ui/app/view/heat_readings.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {

void reading(const char* name, const std::string& value, const char* unit, bool is_warning) {
  ui::textColored(styleColours().quiet, name);
  ui::sameLineAt(scaled(118));
  const std::string words = value + " " + shownText(unit);
  is_warning ? ui::textColored(styleColours().warning, words) : ui::text(words);
}

void drawHeat(const Workbench& bench) {
  // A model of one unnamed material has nothing that heat harms.
  const auto tissues = bench.views->tissues().all();
  if (tissues.size() == 1 && tissues.front().material == Material::kGeneric) return;
  const HeatReport& heat = bench.document->report().heat;
  if (!heat.is_known) return reading("Temperature", "-", "°C");
  const HeatReading under = heatOfSurface(heat, bench.document->report().output.material);
  reading("Temperature", shownNumbers("{:.0f}", under.celsius), "°C", under.is_warning);
  for (const Structures::Structure& structure : bench.document->structures()->all()) {
    const HeatReading kept = heatOfKept(heat, structure.material);
    const std::string name = phrase("  of {}", shownText(bench.document->nameOf(structure.material)));
    reading(name.c_str(), shownNumbers("{:.1f}", kept.celsius), "°C", kept.is_warning);
  }
}

}  // namespace kerf
