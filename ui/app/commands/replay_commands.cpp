#include "ui/app/commands/replay_commands.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/run/session/watched_run.h"

namespace kerf::replay_commands {
namespace {

// End of a step; 0: the beginning.
std::size_t endOf(const WatchedRun& run, std::size_t step) { return step == 0 ? 0 : run.steps()[step - 1].end; }

}  // namespace

bool isWatching(const AppContext& c) { return c.bench.watched() != nullptr; }
bool isWatchingAndIdle(const AppContext& c) { return isWatching(c) && !c.bench.job(); }

Expected<void> open(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.watch(path);
  return {};
}

// At the end it restarts from the beginning.
Expected<void> play(AppContext& c, AppWords) {
  WatchedRun& run = *c.bench.watched();
  if (run.moment().is_at_end) run.jumpTo(0);
  run.play();
  return {};
}

Expected<void> pause(AppContext& c, AppWords) {
  c.bench.watched()->pause();
  return {};
}

Expected<void> toggle(AppContext& c, AppWords words) {
  return c.bench.watched()->moment().is_playing ? pause(c, words) : play(c, words);
}

Expected<void> speed(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] == "fastest") {
    c.bench.watched()->setSpeed(WatchedRun::kFastest);
    return {};
  }
  KERF_TRY(factor, numberOf(words, 0, "FACTOR", WatchedRun::kLeastSpeed, WatchedRun::kMostSpeed));
  c.bench.watched()->setSpeed(factor);
  return {};
}

Expected<void> jump(AppContext& c, AppWords words) {
  WatchedRun& run = *c.bench.watched();
  KERF_TRY(step, numberOf(words, 0, "STEP", 0, static_cast<double>(run.steps().size())));
  const auto whole = static_cast<std::size_t>(step);
  if (static_cast<double>(whole) != step) return wrongWord(fmt::format("step {}", step), "a whole number");
  run.jumpTo(endOf(run, whole));
  return {};
}

Expected<void> time(AppContext& c, AppWords words) {
  WatchedRun& run = *c.bench.watched();
  KERF_TRY(seconds, numberOf(words, 0, "SECONDS", 0, run.seconds()));
  run.jumpTo(static_cast<std::size_t>(seconds / kTick + 0.5));
  return {};
}

Expected<void> next(AppContext& c, AppWords) {
  WatchedRun& run = *c.bench.watched();
  for (const WatchedStep& step : run.steps())
    if (step.end > run.moment().sample) {
      run.jumpTo(step.end);
      return {};
    }
  run.jumpTo(run.samples());
  return {};
}

Expected<void> previous(AppContext& c, AppWords) {
  WatchedRun& run = *c.bench.watched();
  std::size_t to = 0;
  for (const WatchedStep& step : run.steps())
    if (step.end < run.moment().sample) to = std::max(to, step.end);
  run.jumpTo(to);
  return {};
}

Expected<void> begin(AppContext& c, AppWords) {
  c.bench.watched()->jumpTo(0);
  return {};
}

Expected<void> end(AppContext& c, AppWords) {
  c.bench.watched()->jumpTo(c.bench.watched()->samples());
  return {};
}

Expected<void> goOn(AppContext& c, AppWords) { return c.bench.goOnCutting(); }

Expected<void> close(AppContext& c, AppWords) {
  c.bench.endWatching();
  return {};
}

}  // namespace kerf::replay_commands
