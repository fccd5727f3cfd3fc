#include "sim/run/report/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sim/run/report/log_player.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::LogPlayer;

Expected<Replay> playUntil(LogPlayer& player, const SessionLog& log, double until_s, const Progress& progress,
                           const AtEnd& at_end) {
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
  if (at_end) at_end(player.session(), log);
  return out;
}

}  // namespace

Expected<Replay> replay(const SessionLog& log, const std::string& file, Model model, LoadedObjects objects,
                        const Progress& progress, double until_s, double from_s, const AtEnd& at_end) {
  Rigid3 place;
  KERF_CHECK(restoreSettings(log, file, model, place));

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

    LogPlayer player(log, file, model, place, objects, {n + 1, log.events[n].samples_before, std::move(state)});
    auto out = playUntil(player, log, until_s, progress, at_end);
    // An undo may need data that only an earlier state has.
    if (out || out.error().code == Error::Code::kCancelled) return out;
  }
  LogPlayer player(log, file, model, place, objects, {});
  return playUntil(player, log, until_s, progress, at_end);
}

Expected<Replay> internal::replayRun(const fs::path& run_folder, const RunManifest& manifest, const Progress& progress,
                                     const AtEnd& at_end, double until_s, double from_s) {
  KERF_TRY(recording, loadRecording(run_folder, manifest, progress));

  // The state after a gap never existed: do not continue from there.
  if (manifest.is_open)
    for (const SessionEvent& event : recording.log.events)
      if (std::holds_alternative<SessionGap>(event.what))
        until_s = std::min(until_s, static_cast<double>(event.samples_before) * kTick);
  auto out = replay(recording.log, recording.log_file.string(), std::move(recording.model),
                    std::move(recording.objects), progress, until_s, from_s, at_end);
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
