#include "sim/run/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "geometry/base/hash.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/load_scene.h"
#include "sim/run/run_files.h"
#include "sim/run/run_output.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> cancelledReplay() { return fail({.code = Error::Code::kCancelled, .found = "cancelled"}); }

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

// One pass through a log: the samples are ticked, each event is done or compared where it stands.
class Replayer {
 public:
  /// @param log, file  kept by reference.   @param place  of the tool, at the beginning.
  Replayer(const SessionLog& log, const std::string& file, const Model& model, const Rigid3& place,
           const LoadedObjects& objects, Start start)
      : log_(log), file_(file) {
    if (start.state) {
      session_.emplace(std::move(*start.state), model, objects);
      event_ = start.event + 1;
      first_sample_ = log.events[start.event].samples_before;
      out_.first_tick = log.events[start.event].tick + 1;
    } else {
      session_.emplace(model, objects, place);
    }
  }

  Expected<Replay> run(const Progress& progress, double until_s, const AtEnd& at_end) {
    noteHowTheLogEnds();
    KERF_CHECK(tickSamples(progress, until_s));
    const std::size_t done = first_sample_ + out_.ticks;
    if (done == log_.samples.size())
      KERF_CHECK(handleEvents(done));
    else
      compareChecks(done);
    finish();
    if (at_end) at_end(*session_, log_);
    return std::move(out_);
  }

 private:
  void note(const std::string& more) { out_.note += (out_.note.empty() ? "" : "; ") + more; }

  void noteHowTheLogEnds() {
    if (log_.damage)
      out_.note = (log_.damage->kind == LogDamage::Kind::kCutShort ? "the log was cut off: " : "the log is damaged: ") +
                  log_.damage->what;
    else if (!log_.is_closed)
      out_.note = "the log was cut off between two records: its session did not end cleanly";
  }

  Expected<void> tickSamples(const Progress& progress, double until_s) {
    const std::size_t count = log_.samples.size();
    StepOutput tick;
    for (std::size_t n = first_sample_; n < count; ++n) {
      if (static_cast<double>(n) * kTick >= until_s) break;
      if (n % 64 == 0 && !report(progress, static_cast<double>(n) / static_cast<double>(count), "replaying"))
        return cancelledReplay();
      KERF_CHECK(handleEvents(n));
      session_->tick(log_.samples[n].sample, tick);
      ticks_without_bricks_ += (tick.status & (kStepBricksRanOut | kStepNearRanOut)) != 0;
      ++out_.ticks;
    }
    return {};
  }

  // All that stand before the sample of that index and were not handled yet.
  Expected<void> handleEvents(std::size_t samples_before) {
    for (; event_ < log_.events.size() && log_.events[event_].samples_before <= samples_before; ++event_)
      KERF_CHECK(handle(log_.events[event_]));
    return {};
  }

  // Stopped on the way: what was recorded right there can still be compared.
  void compareChecks(std::size_t samples_before) {
    for (; event_ < log_.events.size() && log_.events[event_].samples_before <= samples_before; ++event_)
      if (const auto* check = std::get_if<StateCheck>(&log_.events[event_].what))
        compare(*check, log_.events[event_].tick);
  }

  Expected<void> handle(const SessionEvent& e) {
    if (const auto* command = std::get_if<SessionCommand>(&e.what)) return apply(*command, e.tick);
    if (const auto* check = std::get_if<StateCheck>(&e.what))
      compare(*check, e.tick);
    else if (const auto* snapshot = std::get_if<SessionSnapshot>(&e.what))
      return compare(*snapshot, e.tick);
    else if (const auto* gap = std::get_if<SessionGap>(&e.what))
      out_.note = fmt::format("{} samples are missing at tick {}: what follows can not be the same", gap->lost, e.tick);
    return {};
  }

  Expected<void> apply(const SessionCommand& command, std::uint64_t tick) {
    const Expected<Command> parsed = parseCommand(command.text);
    if (!parsed)
      return fail({.code = parsed.error().code,
                   .file = file_,
                   .place = fmt::format("tick {}, command", tick),
                   .found = parsed.error().found,
                   .expected = parsed.error().expected,
                   .hint = "the log was written by another version of Kerf"});
    if (!session_->apply(*parsed))
      return fail({.code = Error::Code::kBadValue,
                   .file = file_,
                   .place = fmt::format("tick {}", tick),
                   .found = "command \"" + command.text + "\", which can not be done there",
                   .expected = "a command that the recorded session did",
                   .hint = "the log fits another case or version"});
    ++out_.commands;
    return {};
  }

  void compare(const StateCheck& check, std::uint64_t tick) {
    const Wrench& f = session_->state().last_force;
    require(check.state_hash == session_->hash() && check.force.force == f.force && check.force.torque == f.torque,
            tick);
  }

  Expected<void> compare(const SessionSnapshot& snapshot, std::uint64_t tick) {
    if (!standsAtItsTick(log_, event_)) return {};
    KERF_TRY(bytes, unpackSnapshot(snapshot));
    const std::vector<std::byte> now = session_->snapshot();
    if (isStateOfThisVersion(bytes)) {
      require(now == bytes, tick);
      ++out_.snapshots;
    } else if (!std::exchange(has_other_snapshots_, true)) {
      note("snapshots of another version of Kerf were not compared");
    }
    return {};
  }

  void require(bool is_same, std::uint64_t tick) {
    ++out_.checks;
    if (is_same || !out_.is_same) return;
    out_.is_same = false;
    out_.differs_at = tick;
  }

  void finish() {
    if (ticks_without_bricks_ > 0)
      note(fmt::format("{} ticks ran out of reserved bricks: they may have cut less than those recorded",
                       ticks_without_bricks_));
    if (out_.checks == 0) {
      out_.is_same = false;
      note("nothing to compare with in these ticks: choose more of them");
    }
    out_.state_hash = fmt::format("{:016x}", session_->hash());
    out_.objects = session_->state().objects.size();
    for (const CutObject& object : session_->state().objects)
      for (std::size_t m = 0; m < object.removed_mm3.size(); ++m)
        out_.removed_mm3 += object.removed_before_mm3[m] + object.removed_mm3[m];
  }

  const SessionLog& log_;
  const std::string& file_;
  std::optional<Session> session_;
  std::size_t event_ = 0, first_sample_ = 0;  // the next event; the sample it began with
  std::uint64_t ticks_without_bricks_ = 0;
  bool has_other_snapshots_ = false;
  Replay out_;
};

// The log's header names what it was recorded with.
class HeaderCheck {
 public:
  HeaderCheck(const SessionLog& log, fs::path file) : log_(log), file_(std::move(file)) {}
  Expected<void> wants(const std::string& key, const std::string& expected) const {
    if (log_.value(key) == expected) return {};
    return refuse(key, std::string(log_.value(key)), expected);
  }
  tl::unexpected<Error> refuse(const std::string& key, std::string found, std::string expected) const {
    return fail({.code = Error::Code::kBadValue,
                 .file = file_.string(),
                 .place = "header, " + key,
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = "the log belongs to another run"});
  }

 private:
  const SessionLog& log_;
  fs::path file_;
};

// At the end of the log the state is that of the run, or the log lacks something.
void compareEnd(const SessionLog& log, const RunManifest& manifest, double until_s, Replay& out) {
  const double held_s = static_cast<double>(log.samples.size()) * kTick;
  const bool is_at_end = out.first_tick + out.ticks == log.samples.size() && held_s < until_s;
  if (!is_at_end || out.state_hash == manifest.state_hash) return;

  const std::string other = "the state at the end is not the one that run.toml names, " + manifest.state_hash;
  if (log.is_closed && !log.damage) {
    out.is_same = false;
    out.note = other;
    return;
  }
  out.is_whole = false;
  out.note += fmt::format("; it holds {:.3f} of {:.3f} s: {}", held_s, manifest.duration_s, other);
}

}  // namespace

Expected<Replay> replay(const SessionLog& log, const std::string& file, Model model, LoadedObjects objects,
                        const Progress& progress, double until_s, double from_s, const AtEnd& at_end) {
  Rigid3 place;
  KERF_CHECK(restoreSettings(log, file, model, place));

  // From the last usable snapshot not after `from_s`, else from the beginning.
  for (std::size_t n = log.events.size(); n-- > 0;) {
    const auto* snapshot = std::get_if<SessionSnapshot>(&log.events[n].what);
    if (!snapshot || !standsAtItsTick(log, n) || static_cast<double>(log.events[n].samples_before) * kTick > from_s)
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

    auto out = Replayer(log, file, model, place, objects, {n, std::move(state)}).run(progress, until_s, at_end);
    // An undo may want what only an earlier state knows.
    if (out || out.error().code == Error::Code::kCancelled) return out;
  }
  return Replayer(log, file, model, place, objects, {}).run(progress, until_s, at_end);
}

namespace {

// The tools of a run, read from its copies, and whether they are those of the log.
Expected<std::vector<Tool>> readTools(const fs::path& run_folder, const RunManifest& manifest, const SessionLog& log,
                                      const HeaderCheck& header) {
  std::vector<RunManifest::ToolFile> files = manifest.tools;
  if (manifest.mode != kModeSession) files = {{manifest.tool_id, internal::kRunToolCopy, manifest.tool_sha256}};

  std::vector<std::string> in_log;
  for (const auto& [key, value] : log.header)
    if (key == "tool_sha256") in_log.push_back(value);
  if (in_log.size() != files.size())
    return header.refuse("tool_sha256", fmt::format("{} tools", in_log.size()),
                         fmt::format("{} of them", files.size()));

  std::vector<Tool> out;
  for (std::size_t n = 0; n < files.size(); ++n) {
    const fs::path file = run_folder / files[n].file;
    KERF_CHECK(requireSha256(file, files[n].sha256, "cut again"));
    if (in_log[n] != files[n].sha256) return header.refuse("tool_sha256", in_log[n], files[n].sha256);
    KERF_TRY(tool, readTool(file));
    out.push_back(std::move(tool));
  }
  return out;
}

}  // namespace

Expected<Replay> internal::replayRun(const fs::path& run_folder, const RunManifest& manifest, const Progress& progress,
                                     const AtEnd& at_end, double until_s, double from_s) {
  if (manifest.mode == kModeGeometry)
    return fail({.code = Error::Code::kUnsupported,
                 .file = run_folder.string(),
                 .place = "mode " + manifest.mode,
                 .found = "no session to replay",
                 .expected = "a run cut against resistance",
                 .hint = "kerf cut --hand"});
  KERF_TRY(case_folder, caseOfRun(run_folder));
  KERF_TRY(beside, casesBesideRun(run_folder));
  if (!report(progress, 0, "loading the case")) return cancelledReplay();

  // The log, and whether it is of this run.
  const fs::path log_file = run_folder / internal::kRunLog;
  KERF_TRY(log, readSessionLog(log_file));
  const HeaderCheck header(log, log_file);
  KERF_CHECK(header.wants("case_id", manifest.case_id));
  for (std::size_t n = 1; n <= beside.size(); ++n)
    KERF_CHECK(header.wants(internal::neighbourKey(n), manifest.beside[n - 1].case_id));
  KERF_CHECK(header.wants(internal::neighbourKey(beside.size() + 1), ""));
  KERF_TRY(tools, readTools(run_folder, manifest, log, header));

  // What it was recorded with.
  LoadedObjects objects;
  beside.insert(beside.begin(), case_folder);
  for (std::size_t n = 0; n < beside.size(); ++n) {
    KERF_TRY(begin, readRunBegin(run_folder, manifest, n));
    KERF_TRY(object, loadObject(beside[n], begin ? &*begin : nullptr));
    objects.push_back(std::move(object));
  }
  KERF_TRY(model, makeModel(tools, {}, widestBand(objects)));

  // What comes after a gap was never so: it is not finished from there.
  if (manifest.is_open)
    for (const SessionEvent& event : log.events)
      if (std::holds_alternative<SessionGap>(event.what))
        until_s = std::min(until_s, static_cast<double>(event.samples_before) * kTick);
  auto out = replay(log, log_file.string(), std::move(model), std::move(objects), progress, until_s, from_s, at_end);
  if (out && !manifest.is_open) compareEnd(log, manifest, until_s, *out);
  return out;
}

Expected<Replay> replayRun(const fs::path& run_folder, const Progress& progress, double until_s, double from_s) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  return internal::replayRun(run_folder, manifest, progress, {}, until_s, from_s);
}

}  // namespace kerf
