#include "ui/app/commands/command_tables.h"

#include <algorithm>
#include <array>
#include <optional>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/drilling.h"
#include "ui/app/workbench/imports.h"

namespace kerf::drill_commands {
namespace {

constexpr double kMostPlace = 1000;  // mm

bool isPlanning(const AppContext& c) {
  return c.bench.document->isOpen() && !c.bench.imports->isImporting() && c.bench.drill->isPlanning();
}
bool isReady(const AppContext& c) { return isPlanning(c) && !c.bench.drill->isDrilling(); }
bool isDrilling(const AppContext& c) { return c.bench.drill->isDrilling(); }

Expected<void> plan(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] != "on" && words[0] != "off") return wrongWord("\"" + words[0] + "\"", "on or off");
  return c.bench.drill->setPlanning(words.empty() ? !c.bench.drill->isPlanning() : words[0] == "on");
}

Expected<void> endPlan(AppContext& c, AppWords) { return c.bench.drill->setPlanning(false); }

Expected<void> at(AppContext& c, AppWords words) {
  KERF_TRY(x, numberOf(words, 0, "X", -kMostPlace, kMostPlace));
  KERF_TRY(y, numberOf(words, 1, "Y", -kMostPlace, kMostPlace));
  std::optional<double> z;
  if (words.size() > 2) {
    KERF_TRY(height, numberOf(words, 2, "Z", -kMostPlace, kMostPlace));
    z = height;
  }
  return c.bench.drill->placeAt(x, y, z, c.camera);
}

Expected<void> click(AppContext& c, AppWords words) {
  KERF_TRY(ray, pointedRay(c, words));
  return c.bench.drill->placeUnder(ray, c.camera);
}

Expected<void> depth(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] == "through") {
    c.bench.drill->setDepth(std::nullopt);
    return {};
  }
  KERF_TRY(mm, numberOf(words, 0, "MM", Drilling::kLeastDepth, Drilling::kMostDepth));
  c.bench.drill->setDepth(mm);
  return {};
}

Expected<void> axis(AppContext& c, AppWords words) {
  constexpr std::array<const char*, 4> kNames{"vertical", "occlusal", "face", "view"};
  const auto at = std::find(kNames.begin(), kNames.end(), words.empty() ? "" : words[0]);
  if (at == kNames.end())
    return wrongWord(words.empty() ? "no axis" : "\"" + words[0] + "\"", "vertical, occlusal, face or view");
  c.bench.drill->setAxis(static_cast<DrillAxis>(at - kNames.begin()), c.camera);
  return {};
}

Expected<void> go(AppContext& c, AppWords) { return c.bench.drill->go(); }

Expected<void> stop(AppContext& c, AppWords) {
  c.bench.drill->stop();
  return {};
}

constexpr AppCommand kRows[] = {
    {"drill.plan", "Tool:3", "Drill holes", "D", "[on|off]",
     "Shows the hole panel. A click on the model then places a hole.", when::isOpen, plan},
    {"drill.at", "", "", "", "X Y [Z]",
     "Places a hole on the surface over X, Y, in mm from the left front corner of the model's box. Z: looks from that "
     "height.",
     when::isOpen, at},
    {"drill.click", "", "", "", "[X Y]", "Places a hole at a pixel, or under the cursor.", when::isOpen, click},
    {"drill.depth", "", "", "", "MM|through", "Sets the depth of the hole's tip below the surface.", when::isOpen,
     depth},
    {"drill.axis", "", "", "", "vertical|occlusal|face|view", "Sets the axis of the hole (default: vertical).",
     when::isOpen, axis},
    {"drill.go", "Tool:3", "Drill this hole", "Enter", "", "Drills the planned hole at 2 mm/s, as one step.", isReady,
     go},
    {"drill.stop", "Tool:3", "Stop drilling", "", "", "Stops drilling and retracts the drill.", isDrilling, stop},
    {"drill.end", "", "", "Esc", "", "Hides the hole panel.", isReady, endPlan},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::drill_commands
