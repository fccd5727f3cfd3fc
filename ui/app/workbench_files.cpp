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

std::uintmax_t Workbench::bytesOfLost(std::size_t n) const { return n < lost_.size() ? bytesOf(lost_[n]) : 0; }

void Workbench::forgetLost(std::size_t n) {
  if (isBusy() || n >= lost_.size()) return;
  const fs::path folder = lost_[n].folder;
  if (const auto done = discardSession(folder); !done)
    complain(done.error());
  else
    say("deleted as asked: " + folder.string());
  lost_ = findLostSessions(options_.data_folder);
}

// ---- After a crash

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
    lost_ = findLostSessions(options_.data_folder);
  };
  job_ = std::move(job);
}

}  // namespace kerf
