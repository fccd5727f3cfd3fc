// What was opened before, and what was lost. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <system_error>

#include "ui/app/user_files.h"
#include "ui/app/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

void Workbench::remember(const fs::path& path) {
  if (!options_.keeps_recent) return;
  const fs::path demos = options_.data_folder / "demo";
  const auto [end, rest] = std::mismatch(demos.begin(), demos.end(), path.begin(), path.end());
  if (end == demos.end()) return;  // one of ours stands on the first screen anyway
  if (const auto added = recent_.add(path); !added) complain(added.error());
}

void Workbench::forgetRecent(std::size_t n) {
  if (const auto done = recent_.forget(n); !done) complain(done.error());
}

std::uintmax_t Workbench::bytesOfLost(std::size_t n) const {
  std::uintmax_t out = 0;
  std::error_code failed;
  if (n < lost_.size())
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(lost_[n].folder, failed))
      if (entry.is_regular_file(failed)) out += entry.file_size(failed);
  return out;
}

void Workbench::forgetLost(std::size_t n) {
  if (isBusy() || n >= lost_.size()) return;
  const fs::path folder = lost_[n].folder;
  {
    const auto lock = RunLock::take(folder);
    if (!lock)
      return complain({.code = Error::Code::kUnsupported,
                       .file = folder.string(),
                       .found = "another program works on it",
                       .hint = "it is no lost session any more"});
    std::error_code failed;
    fs::remove_all(folder, failed);
    if (failed)
      complain({.code = Error::Code::kWriteFailed,
                .file = folder.string(),
                .found = failed.message(),
                .expected = "a folder that can be deleted",
                .hint = "delete it yourself"});
    else
      say("deleted as asked: " + folder.string());
  }
  findLostSessions();
}

// ---- After a crash

void Workbench::findLostSessions() {
  lost_.clear();
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(options_.data_folder / "sessions", failed)) {
    const auto manifest = readRunManifest(entry.path());
    if (!manifest || !manifest->is_open || !RunLock::take(entry.path())) continue;
    lost_.push_back({entry.path(), fs::path(manifest->case_path).stem().string()});
  }
  const auto timeOf = [](const LostSession& lost) {
    std::error_code none;
    return fs::last_write_time(lost.folder / "session.kerflog", none);
  };
  std::sort(lost_.begin(), lost_.end(),
            [&](const LostSession& a, const LostSession& b) { return timeOf(a) > timeOf(b); });
}

void Workbench::recover(std::size_t n) {
  if (isBusy() || n >= lost_.size()) return;
  job_writes_ = true;
  const fs::path folder = lost_[n].folder;
  auto job =
      std::make_unique<Job<Recovery>>("recovering " + folder.filename().string(),
                                      [folder](const Progress& progress) { return recoverRun(folder, progress); });
  when_over_ = [this, job = job.get(), folder] {
    auto recovered = job->take();
    if (recovered) {
      const Replay& replay = recovered->replay;
      const bool differs = !replay.is_same && replay.checks > 0;
      notices_.push_back({differs, fmt::format("recovered {:.1f} s, {:.3f} mm3 removed: {}\n{}{}",
                                               recovered->manifest.duration_s, replay.removed_mm3, folder.string(),
                                               replay.note, differs ? "; it DIFFERS from what was recorded" : "")});
    } else if (recovered.error().code == Error::Code::kEmpty) {
      // A session without a cut is none: its folder holds nothing that anybody made.
      std::error_code ignored;
      fs::remove_all(folder, ignored);
      say("nothing had been cut in that session");
    } else {
      complain(recovered.error());
    }
    findLostSessions();
  };
  job_ = std::move(job);
}

}  // namespace kerf
