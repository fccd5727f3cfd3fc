// Recent files, and the sessions that a crash left behind.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "ui/app/base/user_files.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/workbench_options.h"
#include "ui/app/import/lost_sessions.h"

namespace kerf {

/// Window thread only.
class FileHistory final : public Part {
 public:
  /// @param options  kept by reference; its data_folder is set.
  FileHistory(const WorkbenchOptions& options, Notices& notices, Jobs& jobs);

  RecentFiles& recent() { return recent_; }
  const RecentFiles& recent() const { return recent_; }
  /// Puts a file first in the list, unless the options keep no list or it is one of Kerf's demos.
  void remember(const std::filesystem::path& path);
  void forgetRecent(std::size_t n);

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
  std::vector<LostSession> lost_;
};

}  // namespace kerf
