#include "ui/app/commands/quit.h"

#include "ui/app/base/language.h"
#include "ui/app/commands/export_commands.h"

namespace kerf::quit {

Expected<void> quit(AppContext& c, AppWords) {
  const bool asks = c.asks_before_quit && !c.is_asking_to_quit && c.bench.hasUnexportedCut();
  c.is_asking_to_quit = asks;
  c.wants_quit = !asks;
  return {};
}

bool isAsking(const AppContext& c) { return c.is_asking_to_quit; }

Expected<void> stay(AppContext& c, AppWords) {
  c.is_asking_to_quit = false;
  return {};
}

void exportFirst(AppContext& c) {
  c.is_asking_to_quit = false;
  if (!export_commands::canShow(c)) return;
  if (const auto shown = runAppCommand(c, "export.show", std::vector<std::string>{"on"}); !shown)
    c.bench.complain(shown.error());
}

std::string question(const Workbench& bench) {
  return phrase(
      "Your cut is kept in {}; it was not exported.\nOpen that folder in Kerf to go on with it, or export it now.",
      bench.sessionFolder().string());
}

}  // namespace kerf::quit
