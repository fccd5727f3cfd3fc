// Replays a recorded session: the same bits, or the first tick that differs.
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <string>

#include "geometry/base/progress.h"
#include "sim/run/run_manifest.h"
#include "sim/session/session.h"

namespace kerf {

/// What a replay did and found.
struct Replay {
  std::uint64_t ticks = 0, checks = 0, commands = 0;
  std::uint64_t snapshots = 0;   ///< compared, byte by byte; they are among the checks
  std::uint64_t first_tick = 0;  ///< where it began
  std::uint64_t differs_at = 0;  ///< tick of the first check that did not hold
  bool is_same = true;           ///< every check held, and there was one
  bool is_whole = true;          ///< false: the log ends before its run, so that the rest was not compared
  std::string state_hash;        ///< at the end
  std::string note;              ///< what the log lacks: cut off, damaged, samples lost
  double removed_mm3 = 0;        ///< at the end, of all objects, before and after they came apart
  std::size_t objects = 0;       ///< at the end: cases, and pieces
};

/// Is shown a session where its replay ends.
using AtEnd = std::function<void(const Session& session, const SessionLog& log)>;

/// Runs a log against the objects and tools it was recorded with.
/// @param until_s  simulated seconds after which to stop.
/// @param from_s  begins with the last snapshot not after that, if there is one: what lies before is not compared. An
///   undo that reaches back behind it leads to an earlier one, or to the beginning.
/// Errors: a header that does not fit; kCancelled.
Expected<Replay> replay(const SessionLog& log, const std::string& file, Model model, LoadedObjects objects,
                        const Progress& progress = {}, double until_s = std::numeric_limits<double>::infinity(),
                        double from_s = 0, const AtEnd& at_end = {});

/// The session of a run: session.kerflog, with the cases and the tools the run names. Where the log ends without
/// `until_s` the state has to be the one that run.toml names, unless the session is open.
Expected<Replay> replayRun(const std::filesystem::path& run_folder, const Progress& progress = {},
                           double until_s = std::numeric_limits<double>::infinity(), double from_s = 0);

namespace internal {

/// The same of a manifest that was read.
Expected<Replay> replayRun(const std::filesystem::path& run_folder, const RunManifest& manifest,
                           const Progress& progress, const AtEnd& at_end,
                           double until_s = std::numeric_limits<double>::infinity(), double from_s = 0);

}  // namespace internal

}  // namespace kerf
