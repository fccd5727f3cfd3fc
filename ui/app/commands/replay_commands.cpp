#include "ui/app/commands/command_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/run/session/watched_run.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/replays.h"

namespace kerf::replay_commands {
namespace {

// End of a step; 0: the beginning.
std::size_t endOf(const WatchedRun& run, std::size_t step) { return step == 0 ? 0 : run.steps()[step - 1].end; }

bool isWatching(const AppContext& c) { return c.bench.document->watched() != nullptr; }
bool isWatchingAndIdle(const AppContext& c) { return isWatching(c) && !c.bench.jobs->running(); }

Expected<void> open(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.replays->open(path);
  return {};
}

// At the end it restarts from the beginning.
Expected<void> play(AppContext& c, AppWords) {
  WatchedRun& run = *c.bench.document->watched();
  if (run.moment().is_at_end) run.jumpTo(0);
  run.play();
  return {};
}

Expected<void> pause(AppContext& c, AppWords) {
  c.bench.document->watched()->pause();
  return {};
}

Expected<void> toggle(AppContext& c, AppWords words) {
  return c.bench.document->watched()->moment().is_playing ? pause(c, words) : play(c, words);
}

Expected<void> speed(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] == "fastest") {
    c.bench.document->watched()->setSpeed(WatchedRun::kFastest);
    return {};
  }
  KERF_TRY(factor, numberOf(words, 0, "FACTOR", WatchedRun::kLeastSpeed, WatchedRun::kMostSpeed));
  c.bench.document->watched()->setSpeed(factor);
  return {};
}

Expected<void> jump(AppContext& c, AppWords words) {
  WatchedRun& run = *c.bench.document->watched();
  KERF_TRY(step, numberOf(words, 0, "STEP", 0, static_cast<double>(run.steps().size())));
  const auto whole = static_cast<std::size_t>(step);
  if (static_cast<double>(whole) != step) return wrongWord(fmt::format("step {}", step), "a whole number");
  run.jumpTo(endOf(run, whole));
  return {};
}

Expected<void> time(AppContext& c, AppWords words) {
  WatchedRun& run = *c.bench.document->watched();
  KERF_TRY(seconds, numberOf(words, 0, "SECONDS", 0, run.seconds()));
  run.jumpTo(static_cast<std::size_t>(seconds / kTick + 0.5));
  return {};
}

Expected<void> next(AppContext& c, AppWords) {
  WatchedRun& run = *c.bench.document->watched();
  for (const WatchedStep& step : run.steps())
    if (step.end > run.moment().sample) {
      run.jumpTo(step.end);
      return {};
    }
  run.jumpTo(run.samples());
  return {};
}

Expected<void> previous(AppContext& c, AppWords) {
  WatchedRun& run = *c.bench.document->watched();
  std::size_t to = 0;
  for (const WatchedStep& step : run.steps())
    if (step.end < run.moment().sample) to = std::max(to, step.end);
  run.jumpTo(to);
  return {};
}

Expected<void> begin(AppContext& c, AppWords) {
  c.bench.document->watched()->jumpTo(0);
  return {};
}

Expected<void> end(AppContext& c, AppWords) {
  c.bench.document->watched()->jumpTo(c.bench.document->watched()->samples());
  return {};
}

Expected<void> goOn(AppContext& c, AppWords) { return c.bench.replays->goOnCutting(); }

Expected<void> close(AppContext& c, AppWords) {
  c.bench.replays->end();
  return {};
}

constexpr AppCommand kRows[] = {
    {"replay.open", "File:5", "Watch a session...", "", "PATH",
     "Shows a session that has ended as it was cut, from its beginning.", when::isIdle, open},
    {"replay.play", "", "", "", "", "Plays on; at the end: from the beginning.", isWatching, play},
    {"replay.pause", "", "", "", "", "Holds the session where it is.", isWatching, pause},
    {"replay.toggle", "Replay", "Play or pause", "K", "", "Plays on, or holds the session where it is.", isWatching,
     toggle},
    {"replay.speed", "", "", "", "FACTOR|fastest",
     "Plays 0.25 to 16 times as fast as it was cut, or as fast as it can.", isWatching, speed},
    {"replay.jump", "", "", "", "STEP", "Goes to the end of a step of the session; 0 is the beginning.", isWatching,
     jump},
    {"replay.time", "", "", "", "SECONDS", "Goes to a moment, in seconds of the session's own clock.", isWatching,
     time},
    {"replay.next", "Replay", "To the end of the next step", "N", "", "Goes to the end of the next step.", isWatching,
     next},
    {"replay.previous", "Replay", "To the end of the step before", "B", "", "Goes to the end of the step before.",
     isWatching, previous},
    {"replay.begin", "Replay", "To the beginning", "Shift+B", "", "Goes to the beginning of the session.", isWatching,
     begin},
    {"replay.end", "Replay", "To the end", "Shift+N", "",
     "Goes to the end of the session, and says whether its state is the one that was recorded.", isWatching, end},
    {"replay.go-on", "Replay", "Go on cutting from here", "", "",
     "Opens the session to cut as it is shown, at any moment: a new session goes on from it. Before its end, what was "
     "cut up to there is kept as a run of its own.",
     isWatchingAndIdle, goOn},
    {"replay.close", "Replay", "Watch no more", "Esc", "", "Puts the session away.", isWatching, close},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::replay_commands
