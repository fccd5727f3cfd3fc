// Sessions whose program was killed or lost power. Their logs exist, their runs are open.
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

/// A session without its program, or without its field after a power loss; recoverRun() finishes it.
struct LostSession {
  std::filesystem::path folder;
  std::string case_name;
};

/// Lost sessions in DATA/sessions, newest first, without those in use by a program.   @param data  userDataFolder().
/// O(runs).
std::vector<LostSession> findLostSessions(const std::filesystem::path& data);

/// Bytes of the files in its folder; 0 if the folder is gone.
std::uintmax_t bytesOf(const LostSession& lost);

/// Deletes the whole folder of a lost session.   Errors: kUnsupported for an ended run, and while another program works
/// on it; kWriteFailed, also if the folder has files that Kerf did not write; those of reading its manifest.
Expected<void> discardSession(const std::filesystem::path& folder);

/// Runs of the undone steps of a session that ends without a cut.
struct DroppedRuns {
  std::map<std::uint64_t, std::filesystem::path> runs;  ///< by BranchPoint::step_began
  std::optional<Error> failed;                          ///< write error: the session's folder with its log stays
};
/// Writes a run for each undone step to DATA/sessions, then deletes the session's folder.
/// @param dropped  BranchPoint::step_began of its steps.   @param name  of the object.
/// @cost  a replay of the session for each.
DroppedRuns keepDropped(const std::filesystem::path& session, const std::vector<std::uint64_t>& dropped,
                        const std::filesystem::path& data, const std::string& name, const Progress& progress = {});

}  // namespace kerf
