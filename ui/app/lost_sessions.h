// Sessions whose program is gone: killed, or cut off with the power. Their logs are there, their runs are open.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// A session whose program is gone: recoverRun() finishes it.
struct LostSession {
  std::filesystem::path folder;
  std::string case_name;
};

/// Those in DATA/sessions, the newest first; none of a program that is at work.   @param data  userDataFolder().
/// O(runs).
std::vector<LostSession> findLostSessions(const std::filesystem::path& data);

/// Bytes of the files in its folder; 0 if it is gone.
std::uintmax_t bytesOf(const LostSession& lost);

/// Deletes the folder of an open session, all of it.   Errors: kUnsupported for a run that has ended, and while another
/// program works on it; kWriteFailed, also where something lies in it that Kerf did not write; those of reading its
/// manifest.
Expected<void> discardSession(const std::filesystem::path& folder);

}  // namespace kerf
