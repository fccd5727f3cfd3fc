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
    {"replay.open", "File:5", "Replay session...", "", "PATH", "Replays an ended session from the beginning.",
     when::isIdle, open},
    {"replay.play", "", "", "", "", "Plays the replay. At the end: starts again from the beginning.", isWatching, play},
    {"replay.pause", "", "", "", "", "Pauses the replay.", isWatching, pause},
    {"replay.toggle", "Replay", "Play or pause", "K", "", "Plays or pauses the replay.", isWatching, toggle},
    {"replay.speed", "", "", "", "FACTOR|fastest",
     "Sets the replay speed: 0.25 to 16 times the recorded speed, or fastest.", isWatching, speed},
    {"replay.jump", "", "", "", "STEP", "Goes to the end of a step of the session. 0 is the beginning.", isWatching,
     jump},
    {"replay.time", "", "", "", "SECONDS", "Goes to a time of the session, in seconds.", isWatching, time},
    {"replay.next", "Replay", "Go to next step", "N", "", "Goes to the end of the next step.", isWatching, next},
    {"replay.previous", "Replay", "Go to previous step", "B", "", "Goes to the end of the previous step.", isWatching,
     previous},
    {"replay.begin", "Replay", "Go to beginning", "Shift+B", "", "Goes to the beginning of the session.", isWatching,
     begin},
    {"replay.end", "Replay", "Go to end", "Shift+N", "",
     "Goes to the end of the session and compares its state with the recorded one.", isWatching, end},
    {"replay.go-on", "Replay", "Continue cutting from here", "", "",
     "Continues in a new session from the shown moment. If this is before the end, Kerf also saves the cuts up to here "
     "as a separate run.",
     isWatchingAndIdle, goOn},
    {"replay.close", "Replay", "Close replay", "Esc", "", "Closes the replay.", isWatching, close},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::replay_commands
