#include "ui/app/commands/quit_commands.h"

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
     "Saves the session and closes the window. If the cut is not exported, Kerf asks once (not in scripts).",
     when::always, quit},
    {"app.stay", "", "", "", "", "Cancels quitting while Kerf asks about a cut that is not exported.", isAsking, stay},
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
      "Your cut is saved in {}, but not exported.\n"
      "Export it now, or open that folder in Kerf later to continue.",
      bench.document->sessionFolder().string());
}

}  // namespace kerf::quit
