#include "sim/run/replay.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "geometry/base/hash.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/load_scene.h"
#include "sim/run/run_files.h"

namespace kerf {

void LogSink::flush() {
  if (!batch_.empty()) writer_.addSamples(first_, batch_);
  batch_.clear();
  // A disk that is full is told of by close(): the writer keeps its first error.
  static_cast<void>(writer_.write());
}

void LogSink::sample(const DeviceSample& sample, std::uint64_t tick) noexcept {
  if (batch_.size() == kBatch) flush();
  if (batch_.empty()) first_ = tick;
  batch_.push_back(sample);
  last_ = tick;
}
void LogSink::command(const Command& command, std::uint64_t tick) noexcept {
  flush();
  writer_.add(tick, SessionCommand{printCommand(command)});
}
void LogSink::mark(StrokeMark mark, std::uint64_t tick) noexcept {
  flush();
  writer_.add(tick, mark);
}
void LogSink::check(const StateCheck& check, std::uint64_t tick) noexcept {
  flush();
  writer_.add(tick, check);
}
Expected<void> LogSink::close() {
  flush();
  return writer_.close(last_);
}

void LogSink::snapshot(std::span<const std::byte> state, std::uint64_t tick) noexcept {
  flush();
  // A state too large for a snapshot is none: the log is whole without it.
  if (const auto packed = packSnapshot(state)) writer_.add(tick, *packed);
}

namespace {

// A snapshot made by another thread may stand later than the sample whose state it is.
bool standsAtItsTick(const SessionLog& log, std::size_t event) {
  const std::size_t before = log.events[event].samples_before;
  return before > 0 && log.samples[before - 1].tick == log.events[event].tick;
}

// From the beginning, or from a snapshot: its event, and its state.
struct Start {
  std::size_t event = 0;
  std::optional<State> state;
};

Expected<Replay> replayFrom(const SessionLog& log, const std::string& file, const Model& model, const Rigid3& place,
                            const LoadedObjects& objects, Start start, const Progress& progress, double until_s) {
  Replay out;
  std::optional<Session> made;
  std::size_t event = 0, first_sample = 0;
  if (start.state) {
    made.emplace(std::move(*start.state), model, objects);
    event = start.event + 1;
    first_sample = log.events[start.event].samples_before;
    out.first_tick = log.events[start.event].tick + 1;
  } else {
    made.emplace(model, objects, place);
  }
  Session& session = *made;
  if (log.damage)
    out.note = (log.damage->kind == LogDamage::Kind::kCutShort ? "the log was cut off: " : "the log is damaged: ") +
               log.damage->what;
  else if (!log.is_closed)
    out.note = "the log was cut off between two records: its session did not end cleanly";
  StepOutput tick;
  std::uint64_t lacked_bricks = 0;
  bool has_other_snapshots = false;
  const auto require = [&](bool is_same, std::uint64_t at) {
    ++out.checks;
    if (!is_same && out.is_same) {
      out.is_same = false;
      out.differs_at = at;
    }
  };
  const auto compare = [&](const StateCheck& check, std::uint64_t at) {
    const Wrench& f = session.state().last_force;
    require(check.state_hash == session.hash() && check.force.force == f.force && check.force.torque == f.torque, at);
  };
  const auto handle = [&](std::size_t samples_before) -> Expected<void> {
    for (; event < log.events.size() && log.events[event].samples_before <= samples_before; ++event) {
      const SessionEvent& e = log.events[event];
      if (const auto* command = std::get_if<SessionCommand>(&e.what)) {
        const Expected<Command> parsed = parseCommand(command->text);
        if (!parsed)
          return fail({.code = parsed.error().code,
                       .file = file,
                       .place = fmt::format("tick {}, command", e.tick),
                       .found = parsed.error().found,
                       .expected = parsed.error().expected,
                       .hint = "the log was written by another version of Kerf"});
        if (!session.apply(*parsed))
          return fail({Error::Code::kBadValue, file, fmt::format("tick {}", e.tick),
                       "command \"" + command->text + "\", which can not be done there",
                       "a command that the recorded session did", "the log fits another case or version"});
        ++out.commands;
      } else if (const auto* check = std::get_if<StateCheck>(&e.what)) {
        compare(*check, e.tick);
      } else if (const auto* snapshot = std::get_if<SessionSnapshot>(&e.what)) {
        if (!standsAtItsTick(log, event)) continue;
        KERF_TRY(bytes, unpackSnapshot(*snapshot));
        const std::vector<std::byte> now = session.snapshot();
        if (isStateOfThisVersion(bytes)) {
          require(now == bytes, e.tick);
          ++out.snapshots;
        } else if (!std::exchange(has_other_snapshots, true))
          out.note +=
              (out.note.empty() ? "" : "; ") + std::string("snapshots of another version of Kerf were not compared");
      } else if (const auto* gap = std::get_if<SessionGap>(&e.what)) {
        out.note =
            fmt::format("{} samples are missing at tick {}: what follows can not be the same", gap->lost, e.tick);
      }
    }
    return {};
  };
  for (std::size_t n = first_sample; n < log.samples.size(); ++n) {
    if (static_cast<double>(n) * kTick >= until_s) break;
    if (n % 64 == 0 && !report(progress, static_cast<double>(n) / static_cast<double>(log.samples.size()), "replaying"))
      return fail({Error::Code::kCancelled, "", "", "cancelled", "", ""});
    KERF_CHECK(handle(n));
    session.tick(log.samples[n].sample, tick);
    lacked_bricks += (tick.status & (kStepBricksRanOut | kStepNearRanOut)) != 0;
    ++out.ticks;
  }
  const std::size_t done = first_sample + out.ticks;
  if (done == log.samples.size())
    KERF_CHECK(handle(log.samples.size()));
  else  // stopped on the way: what was recorded right there can still be compared
    for (; event < log.events.size() && log.events[event].samples_before <= done; ++event)
      if (const auto* check = std::get_if<StateCheck>(&log.events[event].what)) compare(*check, log.events[event].tick);
  const auto note = [&out](const std::string& more) { out.note += (out.note.empty() ? "" : "; ") + more; };
  if (lacked_bricks > 0)
    note(fmt::format("{} ticks lacked room: they may have cut less than those recorded", lacked_bricks));
  if (out.checks == 0) {
    out.is_same = false;
    note("nothing to compare with in these ticks: choose more of them");
  }
  out.state_hash = fmt::format("{:016x}", session.hash());
  out.objects = session.state().objects.size();
  for (const CutObject& object : session.state().objects)
    for (const double volume : object.removed_mm3) out.removed_mm3 += volume;
  return out;
}

}  // namespace

Expected<Replay> replay(const SessionLog& log, const std::string& file, Model model, LoadedObjects objects,
                        const Progress& progress, double until_s, double from_s) {
  Rigid3 place;
  KERF_CHECK(restoreSettings(log, file, model, place));
  for (std::size_t n = log.events.size(); n-- > 0;) {
    const auto* snapshot = std::get_if<SessionSnapshot>(&log.events[n].what);
    if (!snapshot || !standsAtItsTick(log, n) || static_cast<double>(log.events[n].samples_before) * kTick > from_s)
      continue;
    KERF_TRY(bytes, unpackSnapshot(*snapshot));
    if (!isStateOfThisVersion(bytes)) continue;
    KERF_TRY(state, unpackState(bytes, objects, file));
    if (state.tool >= model.tools.size())
      return fail({Error::Code::kBadValue, file, "snapshot", fmt::format("tool {}", state.tool),
                   fmt::format("one of {}", model.tools.size()), "the log belongs to other tools"});
    auto out = replayFrom(log, file, model, place, objects, {n, std::move(state)}, progress, until_s);
    // An undo may want what only an earlier state knows.
    if (out || out.error().code == Error::Code::kCancelled) return out;
  }
  return replayFrom(log, file, model, place, objects, {}, progress, until_s);
}

Expected<Replay> replayRun(const std::filesystem::path& run_folder, const Progress& progress, double until_s,
                           double from_s) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  if (manifest.mode != kModeHaptic)
    return fail({Error::Code::kUnsupported, run_folder.string(), "mode " + manifest.mode, "no session to replay",
                 "a run cut against resistance", "kerf cut --hand"});
  KERF_TRY(case_folder, caseOfRun(run_folder));
  KERF_TRY(beside, casesBesideRun(run_folder));
  if (!report(progress, 0, "loading the case")) return fail({Error::Code::kCancelled, "", "", "cancelled", "", ""});
  KERF_TRY(log, readSessionLog(run_folder / internal::kRunLog));
  const auto wants = [&](const char* key, const std::string& found) -> Expected<void> {
    if (log.value(key) == found) return {};
    return fail({Error::Code::kBadValue, (run_folder / internal::kRunLog).string(), std::string("header, ") + key,
                 std::string(log.value(key)), found, "the log belongs to another run"});
  };
  KERF_CHECK(wants("case_id", manifest.case_id));
  for (std::size_t n = 1; n <= beside.size(); ++n)
    KERF_CHECK(wants(internal::neighbourKey(n).c_str(), manifest.beside[n - 1].case_id));
  KERF_CHECK(wants(internal::neighbourKey(beside.size() + 1).c_str(), ""));
  KERF_CHECK(requireSha256(run_folder / internal::kRunToolCopy, manifest.tool_sha256, "cut again"));
  KERF_CHECK(wants("tool_sha256", manifest.tool_sha256));
  KERF_TRY(tool, readTool(run_folder / internal::kRunToolCopy));
  LoadedObjects objects;
  beside.insert(beside.begin(), case_folder);
  for (const std::filesystem::path& folder : beside) {
    KERF_TRY(object, loadObject(folder));
    objects.push_back(std::move(object));
  }
  KERF_TRY(model, makeModel(std::span(&tool, 1), {}, widestBand(objects)));
  auto out = replay(log, (run_folder / internal::kRunLog).string(), std::move(model), std::move(objects), progress,
                    until_s, from_s);
  if (out && log.is_closed && out->first_tick + out->ticks == log.samples.size() &&
      out->state_hash != manifest.state_hash) {
    out->is_same = false;
    out->note = "the state at the end is not the one that run.toml names, " + manifest.state_hash;
  }
  return out;
}

}  // namespace kerf
