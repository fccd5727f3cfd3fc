// Recent files, saved sessions, and the sessions that a crash left behind.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "ui/app/base/user_files.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/workbench_options.h"
#include "ui/app/import/lost_sessions.h"
#include "ui/app/import/session_list.h"

namespace kerf {

/// Window thread only.
class FileHistory final : public Part {
 public:
  /// @param options  kept by reference; its data_folder is set.
  FileHistory(const WorkbenchOptions& options, Notices& notices, Jobs& jobs);

  RecentFiles& recent() { return recent_; }
  const RecentFiles& recent() const { return recent_; }
  /// Puts an opened file first in the list, unless the options keep no list or it is one of Kerf's demos
  /// or cases.
  void remember(const std::filesystem::path& path);
  /// A session of the opened file was written: puts it first in the list, in place of the file.
  void sessionWritten(const std::filesystem::path& folder);
  void forgetRecent(std::size_t n);

  /// Sessions below the data folder, newest first, as of the last refreshSessions().
  const std::vector<SavedSession>& sessions() const { return sessions_; }
  void refreshSessions();
  /// Renames a session and its entry in the list of recent files.
  Expected<void> renameSession(std::size_t n, const std::string& name);
  /// Deletes a session for good, after the caller has asked the user.
  Expected<void> deleteSession(std::size_t n);

  const std::vector<LostSession>& lostSessions() const { return lost_; }
  /// Size of its folder, mostly the log.
  std::uintmax_t bytesOfLost(std::size_t n) const;
  /// Deletes the folder with its log for good, after the caller has asked the user.
  void forgetLost(std::size_t n);
  /// Finishes the session from its log into a run for `kerf export`. A job.
  void recover(std::size_t n);

 private:
  const WorkbenchOptions& options_;
  Notices& notices_;
  Jobs& jobs_;
  RecentFiles recent_;
  std::filesystem::path opened_;  // of the open document, in the list; empty: a demo
  std::vector<LostSession> lost_;
  std::vector<SavedSession> sessions_;
};

}  // namespace kerf
