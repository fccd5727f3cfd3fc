#include "sim/run/report/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sim/run/report/log_player.h"
#include "sim/session/checkpoint.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::LogPlayer;

Expected<Replay> playUntil(LogPlayer& player, const SessionLog& log, double until_s, const Progress& progress) {
  const std::size_t count = log.samples.size();
  StepOutput tick;
  while (!player.isAtEnd() && static_cast<double>(player.nextSample()) * kTick < until_s) {
    const std::size_t n = player.nextSample();
    if (n % 64 == 0 && !report(progress, static_cast<double>(n) / static_cast<double>(count), "replaying"))
      return fail({.code = Error::Code::kCancelled, .found = "cancelled"});
    KERF_CHECK(player.tick(tick));
  }

  // Stopped on the way: the checks recorded right there can still be compared.
  if (player.isAtEnd())
    KERF_CHECK(player.handleEvents());
  else
    player.compareChecks();
  Replay out = player.found();
  if (out.checks == 0) {
    out.is_same = false;
    out.note += fmt::format("{}nothing to compare in these ticks: choose a longer range", out.note.empty() ? "" : "; ");
  }
  return out;
}

// A checkpoint of this log, whose samples and events it still has.
Expected<LogPlayer::Start> startAt(const fs::path& checkpoint, const SessionLog& log, const Model& model,
                                   const LoadedObjects& objects) {
  KERF_TRY(found, readCheckpoint(checkpoint, objects));
  const bool has_samples = found.samples <= log.samples.size() && found.events <= log.events.size();
  const bool is_at_tick =
      found.samples == 0 || (has_samples && log.samples[found.samples - 1].tick + 1 == found.state.tick);
  if (has_samples && is_at_tick && found.state.tool < model.tools.size())
    return LogPlayer::Start{found.events, found.samples, std::move(found.state), found.rest, true};
  return fail({.code = Error::Code::kBadValue,
               .file = checkpoint.string(),
               .place = "checkpoint",
               .found = fmt::format("a state after {} samples", found.samples),
               .expected = fmt::format("one of this log, with {} samples", log.samples.size()),
               .hint = "the power failed before the log reached the disk, or the file is of another session"});
}

}  // namespace

Expected<Replay> replay(const SessionLog& log, const std::string& file, Model model, LoadedObjects objects,
                        const Progress& progress, double until_s, double from_s, const AtEnd& at_end,
                        std::span<const fs::path> checkpoints) {
  Rigid3 place;
  KERF_CHECK(restoreSettings(log, file, model, place));

  // Plays to the end, or leaves a note why not.
  std::string left_out;
  const auto play = [&](LogPlayer::Start start) -> Expected<Replay> {
    const bool has_start = start.state.has_value();
    LogPlayer player(log, file, model, place, objects, std::move(start));
    KERF_TRY(out, playUntil(player, log, until_s, progress));
    if (has_start && out.differs_at > 0 && !checkpoints.empty())
      return fail({.file = file, .found = fmt::format("the replay from there differs at tick {}", out.differs_at)});
    out.note = left_out + out.note;
    if (at_end) at_end(player.session(), log);
    return out;
  };
  for (const fs::path& checkpoint : checkpoints) {
    auto start = startAt(checkpoint, log, model, objects);
    auto out = start ? play(std::move(*start)) : tl::unexpected(std::move(start).error());
    if (out || out.error().code == Error::Code::kCancelled) return out;
    left_out += fmt::format("{} was left out: {}; ", checkpoint.filename().string(), out.error().found);
  }

  // Starts at the last usable snapshot not after `from_s`, else at the beginning.
  for (std::size_t n = log.events.size(); n-- > 0;) {
    const auto* snapshot = std::get_if<SessionSnapshot>(&log.events[n].what);
    if (!snapshot || !internal::standsAtItsTick(log, n) ||
        static_cast<double>(log.events[n].samples_before) * kTick > from_s)
      continue;
    KERF_TRY(bytes, unpackSnapshot(*snapshot));
    if (!isStateOfThisVersion(bytes)) continue;
    KERF_TRY(state, unpackState(bytes, objects, file));
    if (state.tool >= model.tools.size())
      return fail({.code = Error::Code::kBadValue,
                   .file = file,
                   .place = "snapshot",
                   .found = fmt::format("tool {}", state.tool),
                   .expected = fmt::format("one of {}", model.tools.size()),
                   .hint = "the log belongs to other tools"});

    auto out = play({n + 1, log.events[n].samples_before, std::move(state)});
    // An undo may need data that only an earlier state has.
    if (out || out.error().code == Error::Code::kCancelled) return out;
  }
  return play({});
}

Expected<Replay> internal::replayRun(const fs::path& run_folder, const RunManifest& manifest, const Progress& progress,
                                     const AtEnd& at_end, double until_s, double from_s,
                                     std::span<const fs::path> checkpoints) {
  KERF_TRY(recording, loadRecording(run_folder, manifest, progress));

  // The state after a gap never existed: do not continue from there.
  if (manifest.is_open)
    for (const SessionEvent& event : recording.log.events)
      if (std::holds_alternative<SessionGap>(event.what))
        until_s = std::min(until_s, static_cast<double>(event.samples_before) * kTick);
  auto out = replay(recording.log, recording.log_file.string(), std::move(recording.model),
                    std::move(recording.objects), progress, until_s, from_s, at_end, checkpoints);
  if (out && !manifest.is_open) compareEnd(recording.log, manifest, until_s, *out);
  if (out)
    for (const std::size_t n : recording.damaged_tools)
      out->note += fmt::format("{}the file of tool {} is damaged; no stroke used it", out->note.empty() ? "" : "; ",
                               recording.tools[n].id);
  return out;
}

Expected<Replay> replayRun(const fs::path& run_folder, const Progress& progress, double until_s, double from_s) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  return internal::replayRun(run_folder, manifest, progress, {}, until_s, from_s);
}

}  // namespace kerf
