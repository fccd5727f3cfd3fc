#include "ui/app/commands/quit.h"

#include "ui/app/base/language.h"
#include "ui/app/commands/command_tables.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/results.h"

namespace kerf::quit {
namespace {

Expected<void> quit(AppContext& c, AppWords) {
  const bool asks = c.asks_before_quit && !c.is_asking_to_quit && c.bench.results->hasUnexportedCut();
  c.is_asking_to_quit = asks;
  c.wants_quit = !asks;
  return {};
}

bool isAsking(const AppContext& c) { return c.is_asking_to_quit; }

Expected<void> stay(AppContext& c, AppWords) {
  c.is_asking_to_quit = false;
  return {};
}

constexpr AppCommand kRows[] = {
    {"app.quit", "File:7", "Quit", "Ctrl+Q", "",
     "Ends the session, writes it and closes the window; a cut that was not exported is asked about once, not in "
     "scripts.",
     when::always, quit},
    {"app.stay", "", "", "", "", "Answers the question about a cut that was not exported: the window stays open.",
     isAsking, stay},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

void exportFirst(AppContext& c) {
  c.is_asking_to_quit = false;
  if (!findAppCommand("export.show")->is_enabled(c)) return;
  if (const auto shown = runAppCommand(c, "export.show", std::vector<std::string>{"on"}); !shown)
    c.bench.notices->complain(shown.error());
}

std::string question(const Workbench& bench) {
  return phrase(
      "Your cut is kept in {}; it was not exported.\nOpen that folder in Kerf to go on with it, or export it now.",
      bench.document->sessionFolder().string());
}

}  // namespace kerf::quit
