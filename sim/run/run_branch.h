// A run that is cut off at a moment and kept as a run of its own: where another way of cutting branches off.
//
// A log only grows: what was taken back is still in it, with all that was cut before. So whatever state a session had
// can be had again. Where it is, is a moment of the log; what it was, a replay up to there tells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/run/run_manifest.h"
#include "sim/session/session_log.h"

namespace kerf {

/// Which moment of a session. One of the two.
struct BranchPoint {
  /// So many samples are ticked, as WatchedRun shows it.
  std::optional<std::size_t> sample{};
  /// UndoStep::origin.tick of a step: with all that was done then, before that step was taken back for the first time.
  /// One that never was: at the end.
  std::optional<std::uint64_t> step_began{};
};

/// Writes a run of mode session that holds what was cut up to a moment: its log is that of the run, up to there. It
/// replays, exports and is gone on from as any other. The run itself is not changed.
/// A run that goes on from another one holds what was cut in that from its first moment on.
/// @param run_folder  cut against resistance, by a person or along a path; a session may be open, if nobody works on
/// it.
/// @param branch_folder  must not exist. It appears whole or not at all.
/// Errors: kEmpty when nothing is cut at that moment, in a run that began with its case; kNotFound for a step that is
/// not in the log; kUnsupported when the log lacks samples before that moment, or its replay differs from what was
/// recorded; those of replayRun(); kCancelled.
/// @cost  as a replay up to that moment: about a quarter of what the session took.
Expected<RunManifest> branchRun(const std::filesystem::path& run_folder, const BranchPoint& point,
                                const std::filesystem::path& branch_folder, const Progress& progress = {});

/// The ends of lines that were taken back in a session, as BranchPoint::step_began, the first one dropped first: before
/// others were cut in their place, or at last. A stroke in air may be among them.
std::vector<std::uint64_t> droppedSteps(const SessionLog& log);
/// The same of a run. Errors: those of reading its log.
Expected<std::vector<std::uint64_t>> droppedSteps(const std::filesystem::path& run_folder);

}  // namespace kerf
