// Cuts off a run at a moment and keeps the result as a run of its own: the start of another way of cutting.
//
// A log only grows: it still holds undone steps and all earlier cuts. So every state of a session can be restored: a
// replay up to the moment of the log reproduces it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/run/files/run_manifest.h"
#include "sim/session/session_log.h"

namespace kerf {

/// A moment of a session. Set one of the two.
struct BranchPoint {
  /// Number of ticked samples, as in WatchedRun.
  std::optional<std::size_t> sample{};
  /// UndoStep::origin.tick of a step. Its branch has all cuts just before that step was undone for the first time. A
  /// step that was never undone: the end.
  std::optional<std::uint64_t> step_began{};
};

/// Writes a run of mode session with the cuts up to a moment. Its log is the log of the run up to there. It replays,
/// exports and continues like any other. The run itself is not changed. If the run continues another one, the branch
/// has the cuts of that run from its first moment on.
/// @param run_folder  cut against resistance, by a person or along a path; an open session is allowed, if no program
///   works on it.
/// @param branch_folder  must not exist. It appears whole or not at all.
/// Errors: kEmpty when nothing is cut at that moment, in a run that began with its case; kNotFound for a step that is
/// not in the log; kUnsupported when the log lacks samples before that moment, or its replay differs from the
/// recording; those of replayRun(); kCancelled.
/// @cost  as a replay up to that moment, 2 to 25 % of the session's time; of an open session from its last checkpoint.
Expected<RunManifest> branchRun(const std::filesystem::path& run_folder, const BranchPoint& point,
                                const std::filesystem::path& branch_folder, const Progress& progress = {});

/// The ends of undone lines of steps in a session, as BranchPoint::step_began, in the order in which they were dropped:
/// other cuts replaced them, or the session ended. A stroke in air may be among them.
std::vector<std::uint64_t> droppedSteps(const SessionLog& log);
/// The same of a run. Errors: those of reading its log.
Expected<std::vector<std::uint64_t>> droppedSteps(const std::filesystem::path& run_folder);

}  // namespace kerf
