#include "ui/app/commands/edit_commands.h"

#include <fmt/format.h>

namespace kerf::edit_commands {

Expected<void> undo(AppContext& c, AppWords) {
  c.bench.undo();
  return {};
}

Expected<void> redo(AppContext& c, AppWords) {
  c.bench.redo();
  return {};
}

Expected<void> go(AppContext& c, AppWords words) {
  KERF_TRY(step, numberOf(words, 0, "STEP", 0, 1e9));
  const auto whole = static_cast<std::uint64_t>(step);
  if (static_cast<double>(whole) != step) return wrongWord(fmt::format("step {}", step), "a whole number");
  return c.bench.goToStep(whole);
}

Expected<void> begin(AppContext& c, AppWords) { return c.bench.goToStep(c.bench.timeline().older()); }

Expected<void> end(AppContext& c, AppWords) {
  const Timeline& timeline = c.bench.timeline();
  return c.bench.goToStep(timeline.older() + timeline.steps().size());
}

bool hasBranches(const AppContext& c) { return c.bench.isOpen() && !c.bench.job() && c.bench.branchCount() > 0; }

Expected<void> branch(AppContext& c, AppWords words) {
  const auto count = static_cast<double>(c.bench.branchCount());
  KERF_TRY(n, numberOr(words, 0, count, "N", 1, count));
  const auto whole = static_cast<std::size_t>(n);
  if (static_cast<double>(whole) != n) return wrongWord(fmt::format("branch {}", n), "a whole number");
  return c.bench.takeBranch(whole - 1);
}

}  // namespace kerf::edit_commands
