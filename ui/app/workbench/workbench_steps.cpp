// Sends commands to the simulation; undo and redo of steps. The rest of the workbench: workbench.cpp.
#include <algorithm>
#include <utility>

#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

bool Workbench::send(const Command& command) {
  if (!run_->send(command)) return false;
  ++sent_;
  return true;
}

void Workbench::undo() {
  if (!run_) return;
  if (saw_->isCutting()) return saw_->stopAndUndo();
  release();
  // A cut since the last report is a stroke still unknown to the timeline.
  const std::size_t done = stepsDone(), strokes = strokesDone();
  undoOrRedo(done > 0 ? -static_cast<std::ptrdiff_t>(strokes - timeline_.strokesAt(done - 1)) : -1);
}

void Workbench::redo() {
  if (!run_) return;
  if (isSawing()) return;
  release();
  const std::size_t done = stepsDone(), strokes = strokesDone();
  const bool is_known = done < timeline_.steps().size();
  undoOrRedo(is_known ? static_cast<std::ptrdiff_t>(timeline_.strokesAt(done + 1) - strokes) : 1);
}

Expected<void> Workbench::goToStep(std::uint64_t step) {
  if (!run_) return fail({.code = Error::Code::kEmpty, .found = "nothing is open", .hint = "open a scan first"});
  KERF_TRY(strokes, timeline_.strokesAfter(step));
  if (saw_->isCutting())
    return fail({.code = Error::Code::kUnsupported,
                 .found = "a plane is being sawn",
                 .expected = "a tool at rest",
                 .hint = "wait for it, or stop it (saw.stop)"});
  // A stroke or move still on its way to the simulation is not yet a counted step.
  const bool is_counted = !stroke_ && !wish_ && (answered() >= sent_ || undos_answered_at_ == sent_);
  release();
  if (is_counted) {
    undoOrRedo(static_cast<std::ptrdiff_t>(strokes) - static_cast<std::ptrdiff_t>(strokesDone()));
    return {};
  }
  constexpr std::uint64_t kTicks = 5;  // from release to the end of the stroke
  (void)run_->thread().update();
  wish_ = Wish{step, run_->thread().report().tick + kTicks};
  return {};
}

void Workbench::goWhereWished() {
  if (!wish_ || undos_left_ != 0 || answered() < sent_ || report_.tick < wish_->tick) return;
  const std::uint64_t step = std::exchange(wish_, std::nullopt)->step;
  if (const auto gone = goToStep(step); !gone) complain(gone.error());
}

std::size_t Workbench::stepsDone() const { return timeline_.doneAt(strokesDone()); }

// Expected number once all commands are done.
std::size_t Workbench::strokesDone() const {
  const bool is_over = undos_left_ == 0 && answered() >= undos_answered_at_;
  return is_over ? timeline_.strokesDone() : static_cast<std::size_t>(std::max<std::ptrdiff_t>(strokes_then_, 0));
}

void Workbench::undoOrRedo(std::ptrdiff_t strokes) {
  if (strokes == 0) return;
  strokes_then_ = static_cast<std::ptrdiff_t>(strokesDone()) + strokes;
  undos_left_ += strokes;
  sendUndos();
}

// Limits the batch so that the queue has places left for other commands.
void Workbench::sendUndos() {
  constexpr std::uint64_t kMost = HapticThread::kMostCommands / 2;
  while (undos_left_ != 0 && sent_ < answered() + kMost) {
    const bool is_undo = undos_left_ < 0;
    if (!send(is_undo ? Command(Undo{}) : Command(Redo{}))) return;
    undos_left_ += is_undo ? 1 : -1;
    undos_answered_at_ = sent_;
  }
}

}  // namespace kerf
