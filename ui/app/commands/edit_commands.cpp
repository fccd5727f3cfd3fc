#include "ui/app/commands/command_tables.h"

#include <fmt/format.h>

#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/steps.h"

namespace kerf::edit_commands {
namespace {

Expected<void> undo(AppContext& c, AppWords) {
  c.bench.steps->undo();
  return {};
}

Expected<void> redo(AppContext& c, AppWords) {
  c.bench.steps->redo();
  return {};
}

Expected<void> go(AppContext& c, AppWords words) {
  KERF_TRY(step, numberOf(words, 0, "STEP", 0, 1e9));
  const auto whole = static_cast<std::uint64_t>(step);
  if (static_cast<double>(whole) != step) return wrongWord(fmt::format("step {}", step), "a whole number");
  return c.bench.steps->goToStep(whole);
}

Expected<void> begin(AppContext& c, AppWords) { return c.bench.steps->goToStep(c.bench.steps->timeline().older()); }

Expected<void> end(AppContext& c, AppWords) {
  const Timeline& timeline = c.bench.steps->timeline();
  return c.bench.steps->goToStep(timeline.older() + timeline.steps().size());
}

// A session behind an import stays as it is.
bool isAtHand(const AppContext& c) { return when::isOpen(c) && !c.bench.imports->isImporting(); }

bool hasBranches(const AppContext& c) {
  return c.bench.document->isOpen() && !c.bench.jobs->running() && c.bench.steps->branchCount() > 0;
}

Expected<void> branch(AppContext& c, AppWords words) {
  const auto count = static_cast<double>(c.bench.steps->branchCount());
  KERF_TRY(n, numberOr(words, 0, count, "N", 1, count));
  const auto whole = static_cast<std::size_t>(n);
  if (static_cast<double>(whole) != n) return wrongWord(fmt::format("branch {}", n), "a whole number");
  return c.bench.steps->takeBranch(whole - 1);
}

Expected<void> showPalette(AppContext& c, AppWords) {
  c.wants_palette = true;
  return {};
}

constexpr AppCommand kRows[] = {
    {"edit.undo", "Edit:1", "Undo", "Ctrl+Z", "", "Undoes the last stroke.", isAtHand, undo},
    {"edit.redo", "Edit:1", "Redo", "Ctrl+Y", "", "Redoes the last undone stroke.", isAtHand, redo},
    {"edit.go", "", "", "", "STEP", "Goes to the end of a step of the timeline. 0 is the beginning.", isAtHand, go},
    {"edit.begin", "Edit:1", "Undo all steps", "Ctrl+Home", "", "Undoes all steps that the timeline stores.", isAtHand,
     begin},
    {"edit.end", "Edit:1", "Redo all steps", "Ctrl+End", "", "Redoes all undone steps.", isAtHand, end},
    {"edit.branch", "Edit:1", "Continue a branch", "", "[N]",
     "Continues a branch, undone steps that later cuts replaced, in a new session. N as in the timeline (default: the "
     "last). Your current steps are kept as a branch.",
     hasBranches, branch},
    {"palette.show", "Edit:2", "Commands...", "Ctrl+Shift+P", "", "Finds a command by name and runs it.", when::always,
     showPalette},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::edit_commands
