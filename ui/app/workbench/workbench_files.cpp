// Recent files and recovery of lost sessions. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>

#include "sim/run/session/run_branch.h"
#include "ui/app/base/language.h"
#include "ui/app/base/user_files.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

void Workbench::remember(const fs::path& path) {
  if (!options_.keeps_recent) return;
  const fs::path demos = options_.data_folder / "demo";
  const auto [end, rest] = std::mismatch(demos.begin(), demos.end(), path.begin(), path.end());
  if (end == demos.end()) return;  // the first screen lists our demos anyway
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
    say(phrase("deleted as asked: {}", folder.string()));
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
  if (dropped.runs.empty()) return "nothing had been cut in that session";
  std::string out = "nothing is left of the session; what was taken back in it is kept:";
  for (const auto& [began, run] : dropped.runs) out += fmt::format("\n{}", run.string());
  return out;
}

}  // namespace

void Workbench::recover(std::size_t n) {
  if (isBusy() || n >= lost_.size()) return;
  job_writes_ = true;
  const fs::path folder = lost_[n].folder;
  auto job = std::make_unique<Job<RecoveredSession>>(
      phrase("recovering {}", folder.filename().string()),
      [lost = lost_[n], data = options_.data_folder](const Progress& progress) -> Expected<RecoveredSession> {
        return recoverSession(lost, data, progress);
      });
  when_over_ = [this, job = job.get(), folder] {
    auto over = job->take();
    if (!over) return complain(over.error());
    const Expected<Recovery>& recovered = over->run;
    if (recovered) {
      const Replay& replay = recovered->replay;
      const bool differs = !replay.is_same && replay.checks > 0;
      notices_.push_back({differs, fmt::format("recovered {:.1f} s, {:.3f} mm3 removed: {}\n{}{}",
                                               recovered->manifest.duration_s, replay.removed_mm3, folder.string(),
                                               replay.note, differs ? "; it DIFFERS from what was recorded" : "")});
    } else if (recovered.error().code != Error::Code::kEmpty) {
      complain(recovered.error());
    } else if (over->dropped.failed) {
      complain(*over->dropped.failed);
    } else {
      say(tellEmpty(over->dropped));
    }
    lost_ = findLostSessions(options_.data_folder);
  };
  job_ = std::move(job);
}

}  // namespace kerf
