// A session log that is played: its samples are ticked, each command is done and each check compared where it stands.
//
// replay.h plays a log to its end; watched_run.h shows it to a person.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/field/brick_field.h"
#include "geometry/tool/tool.h"
#include "sim/run/replay.h"
#include "sim/run/run_manifest.h"
#include "sim/session/session.h"

namespace kerf::internal {

/// The log of a run, with the objects and tools it was recorded with.
struct Recording {
  RunManifest manifest;
  std::filesystem::path log_file;
  SessionLog log;
  std::vector<std::filesystem::path> cases;  ///< the one that was cut, then those beside it
  std::optional<BrickField> begin;           ///< what an earlier run had cut, from which it went on
  std::vector<Tool> tools;
  std::set<std::size_t> damaged_tools;  ///< no stroke was cut with them: another one stands in the place of each
  LoadedObjects objects;                ///< of `cases`
  Model model;                          ///< of the tools; restoreSettings() puts the log's numbers into it
};

/// Errors: kUnsupported for a run that was cut geometry-only; kBadValue for a log of another run; those of the readers;
/// kCancelled.   @cost  seconds for a tooth, 15 for a mandible at 0.05 mm.
Expected<Recording> loadRecording(const std::filesystem::path& run_folder, const RunManifest& manifest,
                                  const Progress& progress);

/// At the end of the log the state is that of the run, or the log lacks something: `out` says so.
/// @param until_s  where the replay was to stop; infinity: at the end of the log.
void compareEnd(const SessionLog& log, const RunManifest& manifest, double until_s, Replay& out);

/// One pass through a log. One thread.
class LogPlayer {
 public:
  /// From the beginning, or from a state that was kept.
  struct Start {
    std::size_t event = 0;   ///< the first one to be handled
    std::size_t sample = 0;  ///< the next one to be ticked
    std::optional<State> state{};
  };
  /// @param log, file  kept by reference.   @param place  of the tool, at the beginning.
  LogPlayer(const SessionLog& log, const std::string& file, const Model& model, const Rigid3& place,
            const LoadedObjects& objects, Start start);

  std::size_t nextSample() const noexcept { return sample_; }
  std::size_t nextEvent() const noexcept { return event_; }
  bool isAtEnd() const noexcept { return sample_ == log_.samples.size(); }
  Session& session() noexcept { return *session_; }
  const Session& session() const noexcept { return *session_; }

  /// Does and compares what stands before the next sample. At the end: what stands behind the last one.
  /// Errors: a command of another version, or one that can not be done: after a start from a state it may be an undo
  /// that reaches back behind it.
  Expected<void> handleEvents();
  /// handleEvents(), then the next sample.   @pre not at the end.
  Expected<void> tick(StepOutput& output);
  /// Compares what was recorded right here, and does nothing: for who stops on the way.
  void compareChecks();

  /// What was found so far, with hash and volumes of now: milliseconds.
  Replay found() const;

 private:
  void note(const std::string& more) { out_.note += (out_.note.empty() ? "" : "; ") + more; }
  void noteHowTheLogEnds();
  Expected<void> handle(const SessionEvent& e);
  Expected<void> apply(const SessionCommand& command, std::uint64_t tick);
  void compare(const StateCheck& check, std::uint64_t tick);
  Expected<void> compare(const SessionSnapshot& snapshot, std::uint64_t tick);
  void require(bool is_same, std::uint64_t tick);

  const SessionLog& log_;
  const std::string& file_;
  std::optional<Session> session_;
  std::size_t event_ = 0, sample_ = 0;  // the next ones
  std::uint64_t ticks_without_bricks_ = 0;
  bool has_other_snapshots_ = false;
  Replay out_;
};

/// A snapshot made by another thread may stand later than the sample whose state it is.
bool standsAtItsTick(const SessionLog& log, std::size_t event);

}  // namespace kerf::internal
