#include "ui/app/document/file_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "sim/run/session/run_branch.h"
#include "sim/run/session/session_run.h"
#include "ui/app/base/language.h"
#include "ui/app/import/opening.h"

namespace kerf {

namespace fs = std::filesystem;

FileHistory::FileHistory(const WorkbenchOptions& options, Notices& notices, Jobs& jobs)
    : options_(options), notices_(notices), jobs_(jobs), recent_(options.data_folder) {
  lost_ = findLostSessions(options_.data_folder);
}

void FileHistory::remember(const fs::path& path) {
  lost_ = findLostSessions(options_.data_folder);  // opening may have recovered one
  if (!options_.keeps_recent) return;
  opened_.clear();
  // The first screen has buttons for demos, and for the case of a session.
  for (const char* const own : {"demo", "cases", "unpacked-cases"}) {
    const fs::path folder = options_.data_folder / own;
    if (std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end()) return;
  }
  opened_ = path;
  if (const auto added = recent_.add(path); !added) notices_.complain(added.error());
}

void FileHistory::sessionWritten(const fs::path& folder) {
  if (!options_.keeps_recent) return;
  const auto added = opened_.empty() ? recent_.add(folder) : recent_.replace(opened_, folder);
  opened_ = folder;
  if (!added) notices_.complain(added.error());
}

void FileHistory::refreshSessions() { sessions_ = findSessions(options_.data_folder); }

Expected<void> FileHistory::renameSession(std::size_t n, const std::string& name) {
  const fs::path before = sessions_[n].folder;
  KERF_TRY(now, kerf::renameSession(options_.data_folder, before, name));
  refreshSessions();
  lost_ = findLostSessions(options_.data_folder);
  const auto isIt = [&](const RecentFile& file) { return file.path == before; };
  const auto recent = recent_.list();
  return std::any_of(recent.begin(), recent.end(), isIt) ? recent_.replace(before, now) : Expected<void>{};
}

Expected<void> FileHistory::deleteSession(std::size_t n) {
  const fs::path folder = sessions_[n].folder;
  KERF_CHECK(kerf::deleteSession(options_.data_folder, folder));
  notices_.say(phrase("Deleted: {}", folder.string()));
  refreshSessions();
  lost_ = findLostSessions(options_.data_folder);
  const auto recent = recent_.list();
  const auto at = std::find_if(recent.begin(), recent.end(), [&](const auto& file) { return file.path == folder; });
  return at != recent.end() ? recent_.forget(static_cast<std::size_t>(at - recent.begin())) : Expected<void>{};
}

void FileHistory::forgetRecent(std::size_t n) {
  if (const auto done = recent_.forget(n); !done) notices_.complain(done.error());
}

std::uintmax_t FileHistory::bytesOfLost(std::size_t n) const { return n < lost_.size() ? bytesOf(lost_[n]) : 0; }

void FileHistory::forgetLost(std::size_t n) {
  if (jobs_.isBusy() || n >= lost_.size()) return;
  const fs::path folder = lost_[n].folder;
  if (const auto done = discardSession(folder); !done)
    notices_.complain(done.error());
  else
    notices_.say(phrase("Deleted: {}", folder.string()));
  lost_ = findLostSessions(options_.data_folder);
}

// ---- After a crash

namespace {

struct RecoveredSession {
  Expected<Recovery> run;
  DroppedRuns dropped{};  // if the session holds no steps
};

// The log of a session without steps may hold undone cuts. Its folder is deleted only once separate runs keep them.
RecoveredSession recoverSession(const LostSession& lost, const fs::path& data, const Progress& progress) {
  RecoveredSession out{recoverRun(lost.folder, progress)};
  if (out.run || out.run.error().code != Error::Code::kEmpty) return out;
  const auto dropped = droppedSteps(lost.folder);
  if (dropped)
    out.dropped = keepDropped(lost.folder, *dropped, data, lost.case_name, progress);
  else
    out.dropped.failed = dropped.error();
  return out;
}

std::string tellEmpty(const DroppedRuns& dropped) {
  if (dropped.runs.empty()) return "That session has no cuts.";
  std::string out = "No steps are left in the session. Its undone steps are kept:";
  for (const auto& [began, run] : dropped.runs) out += fmt::format("\n{}", run.string());
  return out;
}

}  // namespace

void FileHistory::recover(std::size_t n) {
  if (jobs_.isBusy() || n >= lost_.size()) return;
  const fs::path folder = lost_[n].folder;
  const auto work = [lost = lost_[n],
                     data = options_.data_folder](const Progress& progress) -> Expected<RecoveredSession> {
    return recoverSession(lost, data, progress);
  };
  const auto take = [this, folder](Expected<RecoveredSession> over) {
    if (!over) return notices_.complain(over.error());
    const Expected<Recovery>& recovered = over->run;
    if (recovered) {
      opened_.clear();
      sessionWritten(folder);
      const bool differs = !recovered->replay.is_same && recovered->replay.checks > 0;
      notices_.add({differs, tellRecovery(*recovered) + "\n" + folder.string()});
    } else if (recovered.error().code != Error::Code::kEmpty) {
      notices_.complain(recovered.error());
    } else if (over->dropped.failed) {
      notices_.complain(*over->dropped.failed);
    } else {
      notices_.say(tellEmpty(over->dropped));
    }
    lost_ = findLostSessions(options_.data_folder);
  };
  jobs_.start<RecoveredSession>(Jobs::Kind::kWrites, phrase("recovering {}", folder.filename().string()), work, take);
}

}  // namespace kerf
