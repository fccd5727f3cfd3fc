#include "ui/app/commands/command_tables.h"

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/sawing.h"

namespace kerf::die_commands {
namespace {

bool hasDie(const AppContext& c) {
  return c.bench.document->isOpen() && !c.bench.imports->isImporting() && c.bench.saw->die.isPlanned();
}

Expected<void> plan(AppContext& c, AppWords words) {
  if (words.empty() || words[0].empty()) {
    c.bench.saw->picking.begin(SawPicking::What::kDie);
    return {};
  }
  KERF_TRY(at, rayOf(c, words));
  return c.bench.saw->die.plan(at);
}

Expected<void> set(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("too few parameters", "one of " + DieMaking::names(), "plane.die-set pin 1.6");
  KERF_TRY(value, numberOf(words, 1, "NUMBER", 0, 1000));
  return c.bench.saw->die.set(words[0], value);
}

Expected<void> cut(AppContext& c, AppWords) { return c.bench.saw->die.cut(); }

constexpr AppCommand kRows[] = {
    {"plane.die", "Saw:3", "Plan die from a tooth", "Shift+D", "[X Y]",
     "Plans a removable die around the tooth at a pixel, or at the next click: its planes and a pin hole.",
     when::isOpen, plan},
    {"plane.die-set", "", "", "", "NAME NUMBER",
     "Sets a number of the die: taper (degrees), base (mm above the underside), sides (2 or 4), kerf, pin (diameter, "
     "0: "
     "none) or pin-depth.",
     when::isOpen, set},
    {"plane.die-cut", "Saw:3", "Cut die at once", "Shift+Enter", "",
     "Cuts the planned die out at once, with its pin hole. Model and die stay.", hasDie, cut},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::die_commands
