// Replays a recorded session: the same bits, or the first tick that differs.
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <string>

#include "geometry/base/progress.h"
#include "sim/run/files/run_manifest.h"
#include "sim/session/session.h"

namespace kerf {

/// Result of a replay.
struct Replay {
  std::uint64_t ticks = 0, checks = 0, commands = 0;
  std::uint64_t snapshots = 0;   ///< compared byte by byte; included in `checks`
  std::uint64_t first_tick = 0;  ///< where the replay began
  std::uint64_t differs_at = 0;  ///< tick of the first failed check
  bool is_same = true;           ///< every check passed, and there was one
  bool is_whole = true;          ///< false: the log ends before its run; the rest was not compared
  std::string state_hash;        ///< at the end
  std::string note;              ///< defects of the log: cut off, damaged, samples lost
  double removed_mm3 = 0;        ///< at the end, of all objects, before and after splits
  std::size_t objects = 0;       ///< at the end: cases, and pieces
};

inline constexpr double kToTheEnd = std::numeric_limits<double>::infinity();

/// Receives the session at the end of its replay.
using AtEnd = std::function<void(const Session& session, const SessionLog& log)>;

/// Runs a log against its recorded objects and tools.
/// @param until_s  simulated seconds after which to stop.
/// @param from_s  begins with the last snapshot not after that, if any, and compares nothing before it. An undo that
///   reaches back before it makes the replay start from an earlier one, or from the beginning.
/// @param checkpoints  newest first: begins with the first of them whose replay to the end matches the checks of the
///   log; the note names those before it. An undo that reaches back before one makes the replay start from the next.
/// Errors: a header that does not fit; kCancelled.
Expected<Replay> replay(const SessionLog& log, const std::string& file, Model model, LoadedObjects objects,
                        const Progress& progress = {}, double until_s = kToTheEnd, double from_s = 0,
                        const AtEnd& at_end = {}, std::span<const std::filesystem::path> checkpoints = {});

/// Replays session.kerflog of a run, with the cases and tools named in the run. If the log ends before `until_s`, its
/// state must be that of run.toml, unless the session is open.
Expected<Replay> replayRun(const std::filesystem::path& run_folder, const Progress& progress = {},
                           double until_s = kToTheEnd, double from_s = 0);

namespace internal {

/// The same with a manifest read before.
Expected<Replay> replayRun(const std::filesystem::path& run_folder, const RunManifest& manifest,
                           const Progress& progress, const AtEnd& at_end, double until_s = kToTheEnd, double from_s = 0,
                           std::span<const std::filesystem::path> checkpoints = {});

}  // namespace internal

}  // namespace kerf
