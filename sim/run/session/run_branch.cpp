#include "sim/run/session/run_branch.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "geometry/base/atomic_file.h"
#include "geometry/case/case_bundle.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_output.h"
#include "sim/run/report/log_player.h"
#include "sim/run/session/session_run.h"
#include "sim/session/checkpoint.h"
#include "sim/session/session_log.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::Recording;

// Number of a log's records before a moment.
struct LogMoment {
  std::size_t samples = 0, events = 0;
};

template <class C>
std::optional<C> commandIn(const SessionEvent& event) {
  const auto* const text = std::get_if<SessionCommand>(&event.what);
  if (!text) return {};
  const auto command = parseCommand(text->text);
  const auto* const wanted = command ? std::get_if<C>(&*command) : nullptr;
  return wanted ? std::optional(*wanted) : std::nullopt;
}

// ---- The moment

LogMoment endOf(const SessionLog& log) { return {log.samples.size(), log.events.size()}; }

// Events before the first sample set up the session: the pieces of the continued run, the added material.
bool isOfBeginning(const SessionEvent& event) {
  return event.samples_before == 0 && std::holds_alternative<SessionCommand>(event.what);
}

// Events right after the last sample are not done yet.
LogMoment behindSample(const SessionLog& log, std::size_t sample) {
  if (sample >= log.samples.size()) return endOf(log);
  const auto isBehind = [&](const SessionEvent& event) {
    return event.samples_before >= sample && !isOfBeginning(event);
  };
  const auto end = std::find_if(log.events.begin(), log.events.end(), isBehind);
  return {sample, static_cast<std::size_t>(end - log.events.begin())};
}

// A step is a stroke, or one of these commands. SessionHistory names its beginning by the same tick as the log.
bool beginsStep(const SessionEvent& event) {
  const auto* const mark = std::get_if<StrokeMark>(&event.what);
  if (mark) return *mark == StrokeMark::kBegin;
  return commandIn<MoveObject>(event) || commandIn<CutByPlanes>(event) || commandIn<DeleteObjects>(event);
}

// The first undo after a step's beginning undoes that step, or one cut on top of it and dropped since: the last step of
// a line goes first.
Expected<LogMoment> beforeUndoOf(const SessionLog& log, std::uint64_t began, const std::string& file) {
  const auto isThere = [&](const SessionEvent& event) { return event.tick == began && beginsStep(event); };
  const auto step = std::find_if(log.events.begin(), log.events.end(), isThere);
  if (step == log.events.end())
    return fail({.code = Error::Code::kNotFound,
                 .file = file,
                 .found = fmt::format("no step begins at tick {}", began),
                 .expected = "a step of the log"});

  const auto isUndo = [](const SessionEvent& event) { return commandIn<Undo>(event).has_value(); };
  const auto undo = std::find_if(step, log.events.end(), isUndo);
  if (undo == log.events.end()) return endOf(log);
  return LogMoment{undo->samples_before, static_cast<std::size_t>(undo - log.events.begin())};
}

Expected<LogMoment> momentOf(const SessionLog& log, const BranchPoint& point, const std::string& file) {
  if (point.step_began) return beforeUndoOf(log, *point.step_began, file);
  return point.sample ? behindSample(log, *point.sample) : endOf(log);
}

// ---- The log up to there

// Objects are frozen for some ms while their pieces are made. In a branch no code would release them.
void releaseFrozen(SessionLog& log, std::uint64_t tick) {
  std::set<std::size_t> frozen;
  for (const SessionEvent& event : log.events) {
    if (const auto freeze = commandIn<FreezeObject>(event)) frozen.insert(freeze->object);
    if (const auto release = commandIn<UnfreezeObject>(event)) frozen.erase(release->object);
    if (const auto split = commandIn<SplitObject>(event)) frozen.erase(split->object);
    if (const auto cut = commandIn<CutByPlanes>(event)) frozen.erase(cut->object);
  }
  for (const std::size_t object : frozen)
    log.events.push_back({tick, log.samples.size(), SessionCommand{printCommand(UnfreezeObject{object})}});
}

Expected<void> cutOff(SessionLog& log, const LogMoment& moment, const std::string& file) {
  log.samples.resize(moment.samples);
  log.events.resize(moment.events);
  for (const SessionEvent& event : log.events)
    if (const auto* const gap = std::get_if<SessionGap>(&event.what))
      return fail({.code = Error::Code::kUnsupported,
                   .file = file,
                   .found = fmt::format("{} samples are missing at tick {}", gap->lost, event.tick),
                   .expected = "a complete log up to there",
                   .hint = "continue the run from its end"});
  log.damage.reset();
  log.is_closed = true;  // writeLog() closes it
  releaseFrozen(log, log.samples.empty() ? 0 : log.samples.back().tick + 1);
  return {};
}

bool isInStroke(const SessionLog& log) {
  bool is_in = false;
  for (const SessionEvent& event : log.events)
    if (const auto* const mark = std::get_if<StrokeMark>(&event.what)) is_in = *mark == StrokeMark::kBegin;
  return is_in;
}

// Writes consecutive samples in batches as large as possible.
void addSamples(SessionLogWriter& writer, std::span<const TimedSample> samples) {
  std::vector<DeviceSample> batch;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    batch.push_back(samples[n].sample);
    const bool is_last = n + 1 == samples.size() || samples[n + 1].tick != samples[n].tick + 1;
    if (!is_last) continue;
    writer.addSamples(samples[n].tick + 1 - batch.size(), batch);
    batch.clear();
  }
}

// Ends the log like Session::finish().
Expected<void> writeLog(const fs::path& file, const SessionLog& log, const Session& session) {
  KERF_TRY(writer, SessionLogWriter::create(file, log.header));
  const std::span<const TimedSample> samples(log.samples);
  std::size_t done = 0;
  for (const SessionEvent& event : log.events) {
    addSamples(writer, samples.subspan(done, event.samples_before - done));
    done = event.samples_before;
    std::visit([&](const auto& what) { writer.add(event.tick, what); }, event.what);
    KERF_CHECK(writer.write());
  }
  addSamples(writer, samples.subspan(done));

  const std::uint64_t last = samples.empty() ? 0 : samples.back().tick;
  if (isInStroke(log)) writer.add(last + 1, StrokeMark::kEnd);
  writer.add(last, StateCheck{session.hash(), session.state().last_force});
  return writer.close(last);
}

// ---- The run

// The files of the run, or the inputs of a cut along a path.
std::vector<SessionTool> toolsOf(const fs::path& run_folder, const Recording& recording) {
  std::vector<SessionTool> out;
  for (std::size_t n = 0; n < recording.tools.size(); ++n) {
    const bool is_session = recording.manifest.mode == kModeSession;
    const fs::path file = is_session ? fs::path(recording.manifest.tools[n].file) : fs::path(internal::kRunToolCopy);
    out.push_back({run_folder / file, recording.tools[n], recording.damaged_tools.contains(n)});
  }
  return out;
}

// The volume removed from neighbours before the session is in begin.vdb; run.toml only has the sum.
Expected<std::vector<SessionNeighbour>> neighboursOf(const fs::path& run_folder, const Recording& recording) {
  std::vector<SessionNeighbour> out;
  for (std::size_t n = 1; n < recording.cases.size(); ++n) {
    const RunManifest::Beside& row = recording.manifest.beside[n - 1];
    SessionNeighbour& other = out.emplace_back();
    other.folder = recording.cases[n];
    other.name = row.name;
    other.has_begin = row.has_begin;
    KERF_TRY(manifest, readCaseManifest(other.folder));
    other.manifest = std::move(manifest);
    KERF_TRY(begin, readRunBegin(run_folder, recording.manifest, n));
    if (!begin) continue;
    KERF_TRY(original, readCaseField(other.folder));
    for (const double volume : internal::removedVolumes(original, *begin, internal::materialsOf(*recording.objects[n])))
      other.removed_mm3 += volume;
  }
  return out;
}

// Writes into an existing folder. The manifest of an ended session comes last: a half-written folder is no run.
Expected<RunManifest> writeBranch(const fs::path& run_folder, const Recording& recording, const SessionLog& log,
                                  const Session& session, const fs::path& folder) {
  KERF_TRY(in_case, readCaseManifest(recording.cases.front()));
  KERF_TRY(beside, neighboursOf(run_folder, recording));
  KERF_TRY(fields, internal::fieldsBefore(run_folder, recording.manifest));
  KERF_TRY(out,
           internal::storeSession(folder, recording.cases.front(), in_case, toolsOf(run_folder, recording), beside));
  for (const std::size_t n : recording.damaged_tools) out.tools[n].sha256 = recording.manifest.tools[n].sha256;
  out.begin_sha256 = recording.manifest.begin_sha256;
  if (!out.begin_sha256.empty()) KERF_CHECK(copyFile(run_folder / internal::kRunBegin, folder / internal::kRunBegin));
  std::error_code ignored;
  if (fs::is_regular_file(run_folder / kSawPlanFile, ignored))
    KERF_CHECK(copyFile(run_folder / kSawPlanFile, folder / kSawPlanFile));

  const PieceLabels labels = internal::labelsOf(run_folder, recording.manifest);
  if (!labels.empty()) KERF_CHECK(writePieceLabels(folder, labels));
  KERF_CHECK(writeLog(folder / internal::kRunLog, log, session));
  out.tool_id = internal::toolsInHand(log, out);
  const auto ended = internal::writeEnd(folder, session, out, labels, fields.loaded(), fields.beside);
  if (ended) return out;
  if (ended.error().code != Error::Code::kEmpty) return fail(ended.error());
  return fail({.code = Error::Code::kEmpty,
               .file = run_folder.string(),
               .found = "nothing is cut up to there",
               .expected = "a moment after the first stroke",
               .hint = "open the case instead: " + recording.cases.front().string()});
}

Expected<AtomicFolder> newFolder(const fs::path& folder) {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(folder, ignored)))
    return fail({.code = Error::Code::kWriteFailed,
                 .file = folder.string(),
                 .found = "the name exists already",
                 .expected = "a new folder in a writable one",
                 .hint = "another name or place"});
  return AtomicFolder::create(folder, false, kRunManifest);
}

}  // namespace

Expected<RunManifest> branchRun(const fs::path& run_folder, const BranchPoint& point, const fs::path& branch_folder,
                                const Progress& progress) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  KERF_TRY(recording, internal::loadRecording(run_folder, manifest, progress));
  const std::string file = recording.log_file.string();
  KERF_TRY(moment, momentOf(recording.log, point, file));
  KERF_CHECK(cutOff(recording.log, moment, file));

  KERF_TRY(folder, newFolder(branch_folder));
  Expected<RunManifest> written = fail({});
  const auto write = [&](const Session& session, const SessionLog& log) {
    written = writeBranch(run_folder, recording, log, session, folder.staging());
  };
  // Where releaseFrozen() ends the log, a checkpoint may hold the events that it replaced: the whole log then.
  const auto& events = recording.log.events;
  const bool is_released = !events.empty() && commandIn<UnfreezeObject>(events.back());
  const auto checkpoints = is_released ? std::vector<fs::path>{} : findCheckpoints(run_folder);
  KERF_TRY(replayed,
           replay(recording.log, file, recording.model, recording.objects, progress, kToTheEnd, 0, write, checkpoints));
  if (replayed.checks > 0 && !replayed.is_same)
    return fail({.code = Error::Code::kUnsupported,
                 .file = file,
                 .place = fmt::format("tick {}", replayed.differs_at),
                 .found = "its replay differs from the recording",
                 .expected = "the same bits",
                 .hint = "continue the run from its end"});
  if (written) KERF_CHECK(folder.commit());
  return written;
}

// Counts every stroke of the log as a step, also one in air that the session did not count. So there are never fewer
// steps than in the session, and its dropped steps are among those found here.
std::vector<std::uint64_t> droppedSteps(const SessionLog& log) {
  std::vector<std::uint64_t> out, line;
  std::size_t done = 0;  // in the line; later ones can be redone
  const auto drop = [&] {
    if (done < line.size()) out.push_back(line.back());
    line.resize(done);
  };

  for (const SessionEvent& event : log.events) {
    if (beginsStep(event)) {
      drop();
      line.push_back(event.tick);
      done = line.size();
    } else if (commandIn<Undo>(event)) {
      done -= done > 0 ? 1 : 0;
    } else if (commandIn<Redo>(event)) {
      done += done < line.size() ? 1 : 0;
    }
  }
  drop();
  return out;
}

Expected<std::vector<std::uint64_t>> droppedSteps(const fs::path& run_folder) {
  KERF_TRY(log, readSessionLog(run_folder / internal::kRunLog));
  return droppedSteps(log);
}

}  // namespace kerf
