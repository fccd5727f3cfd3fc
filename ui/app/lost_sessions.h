// Sessions whose program is gone: killed, or cut off with the power. Their logs are there, their runs are open.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf {

/// A session whose program is gone, or whose field was lost with the power: recoverRun() finishes it.
struct LostSession {
  std::filesystem::path folder;
  std::string case_name;
};

/// Those in DATA/sessions, the newest first; none of a program that is at work.   @param data  userDataFolder().
/// O(runs).
std::vector<LostSession> findLostSessions(const std::filesystem::path& data);

/// Bytes of the files in its folder; 0 if it is gone.
std::uintmax_t bytesOf(const LostSession& lost);

/// Deletes the folder of a lost session, all of it.   Errors: kUnsupported for a run that has ended, and while another
/// program works on it; kWriteFailed, also where something lies in it that Kerf did not write; those of reading its
/// manifest.
Expected<void> discardSession(const std::filesystem::path& folder);

/// What had been taken back in a session in which nothing is left.
struct DroppedRuns {
  std::map<std::uint64_t, std::filesystem::path> runs;  ///< by BranchPoint::step_began
  std::optional<Error> failed;  ///< what could not be written: the session's folder is still there, with its log
};
/// Makes runs of it in DATA/sessions; then the session's folder is deleted.
/// @param dropped  of its steps: BranchPoint::step_began.   @param name  of what was cut.
/// @cost  as a replay of the session, for each.
DroppedRuns keepDropped(const std::filesystem::path& session, const std::vector<std::uint64_t>& dropped,
                        const std::filesystem::path& data, const std::string& name, const Progress& progress = {});

}  // namespace kerf
