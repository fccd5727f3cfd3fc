// Plays a session log: ticks its samples, does each command and compares each check at its place.
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
#include "sim/run/files/run_manifest.h"
#include "sim/run/report/replay.h"
#include "sim/session/session.h"

namespace kerf::internal {

/// The log of a run, with the objects and tools it was recorded with.
struct Recording {
  RunManifest manifest;
  std::filesystem::path log_file;
  SessionLog log;
  std::vector<std::filesystem::path> cases;  ///< the case that was cut, then its neighbours
  std::optional<BrickField> begin;           ///< cut of an earlier run that this one continued
  std::vector<Tool> tools;
  std::set<std::size_t> damaged_tools;  ///< never used for a stroke: a substitute takes the place of each
  LoadedObjects objects;                ///< of `cases`
  Model model;                          ///< of the tools; restoreSettings() sets the log's numbers
};

/// Errors: kUnsupported for a geometry-only run; kBadValue for a log of another run; those of the readers; kCancelled.
/// @cost  seconds for a tooth, 15 for a mandible at 0.05 mm.
Expected<Recording> loadRecording(const std::filesystem::path& run_folder, const RunManifest& manifest,
                                  const Progress& progress);

/// Compares the state at the end of the log with the run's final state. Sets `out` accordingly, also if the log is
/// incomplete.
/// @param until_s  where the replay should stop; infinity: at the end of the log.
void compareEnd(const SessionLog& log, const RunManifest& manifest, double until_s, Replay& out);

/// One pass through a log. One thread.
class LogPlayer {
 public:
  /// From the beginning, or from a kept state.
  struct Start {
    std::size_t event = 0;   ///< first event to handle
    std::size_t sample = 0;  ///< next sample to tick
    std::optional<State> state{};
    SessionRest rest{};
    bool is_checked = false;  ///< the state's hash was compared: counts as a check
  };
  /// @param log, file  kept by reference.   @param place  of the tool, at the beginning.
  LogPlayer(const SessionLog& log, const std::string& file, const Model& model, const Rigid3& place,
            const LoadedObjects& objects, Start start);

  std::size_t nextSample() const noexcept { return sample_; }
  std::size_t nextEvent() const noexcept { return event_; }
  bool isAtEnd() const noexcept { return sample_ == log_.samples.size(); }
  Session& session() noexcept { return *session_; }
  const Session& session() const noexcept { return *session_; }

  /// Does and compares all events before the next sample; at the end, those after the last sample. Errors: a command of
  /// another version, or an impossible one: after a start from a state, for example an undo that reaches back before
  /// that state.
  Expected<void> handleEvents();
  /// handleEvents(), then the next sample.   @pre not at the end.
  Expected<void> tick(StepOutput& output);
  /// Compares the checks recorded right here, without any event's effect: for a stop on the way.
  void compareChecks();

  /// Results so far, with the current hash and volumes. @cost milliseconds.
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

/// Whether a snapshot stands at its own tick: one made by another thread may come later in the log.
bool standsAtItsTick(const SessionLog& log, std::size_t event);

}  // namespace kerf::internal
