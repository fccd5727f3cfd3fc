// The user's saved sessions: the run folders below DATA/sessions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// The picture of a session, in its run folder. May be missing.
inline constexpr const char* kSessionPicture = "picture.png";

struct SavedSession {
  std::filesystem::path folder;  ///< the run
  std::string title;             ///< sessionTitle()
  std::string date;              ///< of the last change: "2026-11-28 21:08", local time
  std::uintmax_t bytes = 0;      ///< of its files
  bool has_ended = true;         ///< false: in use by a program, or lost (LostSession)
};

/// Name of a session to the user: its folder's name without ".run" and without the time that newSessionFolder() adds.
std::string sessionTitle(const std::filesystem::path& folder);
/// Time of the last change of a session: "2026-11-28 21:08", local time. Empty: no such folder.
std::string sessionDate(const std::filesystem::path& folder);

/// Sessions in DATA/sessions, newest first.   @param data  userDataFolder().   @cost  a manifest each.
std::vector<SavedSession> findSessions(const std::filesystem::path& data);

/// Renames the folder of an ended session to NAME.run, in the same place.   @return the new folder.
/// Errors: kBadValue for a name that is no file name, or in use; kUnsupported for a folder elsewhere and while a
/// program uses it; kWriteFailed.
Expected<std::filesystem::path> renameSession(const std::filesystem::path& data, const std::filesystem::path& folder,
                                              const std::string& name);
/// Deletes the folder of a session for good, after the caller has asked the user.
/// Errors: kUnsupported for a folder elsewhere and while a program uses it; kWriteFailed, also if the folder has files
/// that Kerf did not write.
Expected<void> deleteSession(const std::filesystem::path& data, const std::filesystem::path& folder);

}  // namespace kerf
