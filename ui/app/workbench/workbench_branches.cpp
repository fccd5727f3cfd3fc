// Branches: dropped lines of cutting, and continuing them. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>

#include "ui/app/base/language.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

// Deletes a session without steps. Its undone steps become separate runs first.
EndedSession endSession(LiveRun& run, const std::vector<std::uint64_t>& dropped, const fs::path& data_folder,
                        const std::string& name) {
  EndedSession out{.run = run.finish(!dropped.empty())};
  const bool is_empty = !out.run && out.run.error().code == Error::Code::kEmpty;
  if (!is_empty || dropped.empty()) return out;

  DroppedRuns kept = keepDropped(run.folder(), dropped, data_folder, name);
  out.saved = std::move(kept.runs);
  out.failed = std::move(kept.failed);
  return out;
}

std::vector<Branch> Workbench::branches() const {
  std::vector<Branch> out = left_;
  for (const TimelineBranch& branch : timeline_.branches())
    out.push_back({session_, {.step_began = branch.last_began}, describeBranch(branch)});
  return out;
}

// The current line. None: it is empty.
std::optional<Branch> Workbench::lineNow() const {
  const std::uint64_t steps = timeline_.older() + stepsDone();
  if (steps > 0)
    return Branch{session_, {}, phrase("as it was left at step {}, {:.2f} mm3 removed", steps, removedMm3())};
  if (opened_ || run_->from().empty()) return opened_;
  return Branch{run_->from(), {}, phrase("as it was opened, {:.2f} mm3 removed", removedMm3())};
}

// Branches of the ending session.
void Workbench::leaveBranches() {
  const std::size_t known = left_.size();
  left_ = branches();
  for (std::size_t n = known; n < left_.size(); ++n) left_[n].text = phrase("in a session before, {}", left_[n].text);
}

std::vector<std::uint64_t> Workbench::droppedSteps(bool with_ahead) const {
  std::vector<std::uint64_t> out;
  for (const TimelineBranch& branch : timeline_.branches()) out.push_back(branch.last_began);
  const auto ahead = timeline_.ahead(strokesDone());
  if (ahead && (with_ahead || !out.empty())) out.push_back(ahead->last_began);
  return out;
}

// Its log is gone: the steps are in separate runs, or there were none.
Branch Workbench::savedOf(const Branch& branch, const fs::path& gone) const {
  if (branch.run != gone || !branch.point.step_began) return branch;
  const auto at = saved_.find(*branch.point.step_began);
  return at == saved_.end() ? Branch{} : Branch{at->second, {}, branch.text};
}

void Workbench::takeEnded(const EndedSession& ended, const fs::path& folder) {
  saved_ = ended.saved;
  has_written_ = ended.run.has_value();
  has_failed_ = ended.failed || (!ended.run && ended.run.error().code != Error::Code::kEmpty);
  if (ended.failed) complain(*ended.failed);
  if (has_written_ || has_failed_) return;

  for (Branch& branch : left_) branch = savedOf(branch, folder);
  std::erase_if(left_, [](const Branch& branch) { return branch.run.empty(); });
  if (saved_.empty()) return;
  std::string text = "nothing is left of the session; what was taken back in it is kept:";
  for (const auto& [began, run] : saved_) text += fmt::format("\n{}", run.string());
  say(std::move(text));
}

// Replaces the open or watched document.
void Workbench::openBranch(const Branch& branch) {
  const bool is_end = !branch.point.sample && !branch.point.step_began;
  openBy(phrase("going on: {}", branch.text), [branch, is_end, options = openingOptions()](const Progress& progress) {
    return is_end ? openToCut(branch.run, options, progress)
                  : openBranchToCut(branch.run, branch.point, options, progress);
  });
}

Expected<void> Workbench::takeBranch(std::size_t n) {
  if (!run_) return fail({.code = Error::Code::kEmpty, .found = "nothing is open", .hint = "open a scan first"});
  if (n >= branchCount())
    return fail({.code = Error::Code::kBadValue,
                 .found = fmt::format("branch {}", n + 1),
                 .expected = fmt::format("1 to {}", branchCount())});
  if (saw_->isCutting())
    return fail({.code = Error::Code::kUnsupported,
                 .found = "a plane is being sawn",
                 .expected = "a tool at rest",
                 .hint = "wait for it, or stop it (saw.stop)"});
  release();
  const Branch taken = branches()[n];
  const auto now = lineNow();
  const auto ahead = timeline_.ahead(strokesDone());
  const fs::path session = session_;
  reopenWith({}, {}, taken);
  if (run_) return {};  // busy: the session did not end

  left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(n));
  if (ahead)
    left_.push_back(
        {session, {.step_began = ahead->last_began}, phrase("in a session before, {}", describeBranch(*ahead))});
  if (now) left_.push_back(*now);
  return {};
}

}  // namespace kerf
