#include "ui/app/workbench/steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> nothingOpen() {
  return fail({.code = Error::Code::kEmpty, .found = "nothing is open", .hint = "open a scan first"});
}

}  // namespace

void Steps::opened(Opening how) {
  if (how == Opening::kNew) left_.clear();
  opened_.reset();
  timeline_.clear();
  undos_left_ = 0;
  undos_answered_at_ = 0;
  wish_.reset();
}

// Branches of the ending session.
void Steps::closing() {
  if (!bench_.document->isOpen()) return;
  const std::size_t known = left_.size();
  left_ = branches();
  for (std::size_t n = known; n < left_.size(); ++n) left_[n].text = phrase("in an earlier session, {}", left_[n].text);
  undos_left_ = 0;
  wish_.reset();
}

void Steps::update() {
  if (!bench_.document->isOpen()) return;
  timeline_.update(bench_.document->report().undo);
  goWhereWished();
  sendUndos();
}

Expected<void> Steps::requireIdleSaw() const {
  if (!bench_.saw->isCutting()) return {};
  return fail({.code = Error::Code::kUnsupported,
               .found = "a planned cut is running",
               .expected = "a tool at rest",
               .hint = "wait for it, or stop it (saw.stop)"});
}

// ---- Undo and redo

void Steps::undo() {
  if (!bench_.document->isOpen()) return;
  if (bench_.saw->isCutting()) return bench_.saw->stopAndUndo();
  bench_.strokes->release();
  // A cut since the last report is a stroke still unknown to the timeline.
  const std::size_t now = done(), strokes = strokesDone();
  undoOrRedo(now > 0 ? -static_cast<std::ptrdiff_t>(strokes - timeline_.strokesAt(now - 1)) : -1);
}

void Steps::redo() {
  if (!bench_.document->isOpen()) return;
  if (bench_.saw->isBusy()) return;
  bench_.strokes->release();
  const std::size_t now = done(), strokes = strokesDone();
  const bool is_known = now < timeline_.steps().size();
  undoOrRedo(is_known ? static_cast<std::ptrdiff_t>(timeline_.strokesAt(now + 1) - strokes) : 1);
}

Expected<void> Steps::goToStep(std::uint64_t step) {
  Document& document = *bench_.document;
  if (!document.isOpen()) return nothingOpen();
  KERF_TRY(strokes, timeline_.strokesAfter(step));
  KERF_CHECK(requireIdleSaw());
  // A stroke or move still on its way to the simulation is not yet a counted step.
  const bool is_sent = document.isAnswered() || undos_answered_at_ == document.sent();
  const bool is_counted = !bench_.strokes->isPressed() && !wish_ && is_sent;
  bench_.strokes->release();
  if (is_counted) {
    undoOrRedo(static_cast<std::ptrdiff_t>(strokes) - static_cast<std::ptrdiff_t>(strokesDone()));
    return {};
  }
  constexpr std::uint64_t kTicks = 5;  // from release to the end of the stroke
  HapticThread& thread = document.run()->thread();
  (void)thread.update();
  wish_ = Wish{step, thread.report().tick + kTicks};
  return {};
}

void Steps::goWhereWished() {
  const Document& document = *bench_.document;
  if (!wish_ || undos_left_ != 0 || !document.isAnswered() || document.report().tick < wish_->tick) return;
  const std::uint64_t step = std::exchange(wish_, std::nullopt)->step;
  if (const auto gone = goToStep(step); !gone) bench_.notices->complain(gone.error());
}

std::size_t Steps::done() const { return timeline_.doneAt(strokesDone()); }

bool Steps::isSettled() const { return undos_left_ == 0 && bench_.document->answered() >= undos_answered_at_; }

// Expected number once all commands are done.
std::size_t Steps::strokesDone() const {
  return isSettled() ? timeline_.strokesDone() : static_cast<std::size_t>(std::max<std::ptrdiff_t>(strokes_then_, 0));
}

void Steps::undoOrRedo(std::ptrdiff_t strokes) {
  if (strokes == 0) return;
  strokes_then_ = static_cast<std::ptrdiff_t>(strokesDone()) + strokes;
  undos_left_ += strokes;
  sendUndos();
}

// Limits the batch so that the queue has places left for other commands.
void Steps::sendUndos() {
  constexpr std::uint64_t kMost = HapticThread::kMostCommands / 2;
  Document& document = *bench_.document;
  while (undos_left_ != 0 && document.sent() < document.answered() + kMost) {
    const bool is_undo = undos_left_ < 0;
    if (!document.send(is_undo ? Command(Undo{}) : Command(Redo{}))) return;
    undos_left_ += is_undo ? 1 : -1;
    undos_answered_at_ = document.sent();
  }
}

// ---- Branches

std::vector<Branch> Steps::branches() const {
  std::vector<Branch> out = left_;
  for (const TimelineBranch& branch : timeline_.branches())
    out.push_back({bench_.document->sessionFolder(), {.step_began = branch.last_began}, describeBranch(branch)});
  return out;
}

// The current line. None: it is empty.
std::optional<Branch> Steps::lineNow() const {
  const Document& document = *bench_.document;
  const std::uint64_t steps = timeline_.older() + done();
  if (steps > 0)
    return Branch{
        document.sessionFolder(), {}, phrase("left at step {}, {:.2f} mm3 removed", steps, document.removedMm3())};
  if (opened_ || document.run()->from().empty()) return opened_;
  return Branch{document.run()->from(), {}, phrase("as opened, {:.2f} mm3 removed", document.removedMm3())};
}

std::vector<std::uint64_t> Steps::droppedSteps(bool with_ahead) const {
  std::vector<std::uint64_t> out;
  for (const TimelineBranch& branch : timeline_.branches()) out.push_back(branch.last_began);
  const auto ahead = timeline_.ahead(strokesDone());
  if (ahead && (with_ahead || !out.empty())) out.push_back(ahead->last_began);
  return out;
}

// Its log is gone: the steps are in separate runs, or there were none.
Branch Steps::savedOf(const Branch& branch, const fs::path& gone) const {
  if (branch.run != gone || !branch.point.step_began) return branch;
  const auto at = saved_.find(*branch.point.step_began);
  return at == saved_.end() ? Branch{} : Branch{at->second, {}, branch.text};
}

void Steps::sessionEnded(const EndedSession& ended, const fs::path& folder) {
  saved_ = ended.saved;
  if (ended.isWritten() || ended.hasFailed()) return;

  for (Branch& branch : left_) branch = savedOf(branch, folder);
  std::erase_if(left_, [](const Branch& branch) { return branch.run.empty(); });
  if (saved_.empty()) return;
  std::string text = "No steps are left in the session. Its undone steps are kept:";
  for (const auto& [began, run] : saved_) text += fmt::format("\n{}", run.string());
  bench_.notices->say(std::move(text));
}

void Steps::continuesBranch(const std::string& text) { opened_ = Branch{bench_.document->run()->from(), {}, text}; }

Expected<void> Steps::takeBranch(std::size_t n) {
  if (!bench_.document->isOpen()) return nothingOpen();
  if (n >= branchCount())
    return fail({.code = Error::Code::kBadValue,
                 .found = fmt::format("branch {}", n + 1),
                 .expected = fmt::format("1 to {}", branchCount())});
  KERF_CHECK(requireIdleSaw());
  if (bench_.jobs->isBusy()) return {};
  bench_.strokes->release();
  const Branch taken = branches()[n];
  const auto now = lineNow();
  const auto ahead = timeline_.ahead(strokesDone());
  const fs::path session = bench_.document->sessionFolder();
  bench_.sessions->reopen({.branch = taken});

  left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(n));
  if (ahead)
    left_.push_back(
        {session, {.step_began = ahead->last_began}, phrase("in an earlier session, {}", describeBranch(*ahead))});
  if (now) left_.push_back(*now);
  return {};
}

}  // namespace kerf
