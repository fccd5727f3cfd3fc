#include "sim/session/session_history.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>

namespace kerf {
namespace {

bool isSamePose(const Rigid3& a, const Rigid3& b) {
  return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs();
}

// Adds the difference of two states of a ledger.
void addTo(UndoStep& step, const Ledger& before, const Ledger& after) noexcept {
  for (std::size_t m = 0; m < before.removed.size(); ++m) {
    step.removed_mm3 += after.removed[m] - before.removed[m];
    step.added_mm3 += after.added[m] - before.added[m];
  }
}

void addTo(UndoStep& step, const UndoStep& part) noexcept {
  if (part.kind != UndoStep::Kind::kMove && step.kind != UndoStep::Kind::kPlaneCut) step.kind = part.kind;
  step.removed_mm3 += part.removed_mm3;
  step.added_mm3 += part.added_mm3;
  step.deleted += part.deleted;
}

bool has(std::uint64_t which, std::size_t object) noexcept { return (which >> object & 1) != 0; }

}  // namespace

SessionHistory::SessionHistory(std::vector<CutObject>& objects) {
  steps_.reserve(kMostSteps);
  now_.reserve(kMostObjects);
  for (CutObject& object : objects) {
    static_cast<void>(object.strokes().end());  // undo does not reach earlier writes
    now_.push_back(trackedState(object));
  }
}

bool SessionHistory::hasChanges(const std::vector<CutObject>& objects) const noexcept {
  for (std::size_t n = 0; n < objects.size(); ++n)
    if (objects[n].strokes().isOpen() || !isSamePose(now_[n].pose, objects[n].T_world_object)) return true;
  return false;
}

void SessionHistory::forgetRedo(std::vector<CutObject>& objects) noexcept {
  // After an undone split or deletion other objects had these numbers. The records of parts go with them.
  constexpr std::size_t kPart = kMostObjects;
  std::array<std::size_t, kMostObjects> now;  // the present number of each
  std::iota(now.begin(), now.end(), std::size_t{0});
  std::size_t count = objects.size();
  for (std::size_t n = done_; n < steps_.size(); ++n) {
    if (const Split* const split = steps_[n].split.get(); split && split->deleted != 0) {
      std::size_t kept = 0;
      for (std::size_t k = 0; k < count; ++k)
        if (!has(split->deleted, k)) now[kept++] = now[k];
      count = kept;
    } else if (split) {
      now[split->index] = kPart;
      for (std::size_t k = 1; k < split->parts; ++k) now[count++] = kPart;
    }
    while (!steps_[n].records.isEmpty()) {
      StrokeRecord* const record = steps_[n].records.popFront();
      if (now[record->object] != kPart) objects[now[record->object]].memory().release(record);
    }
  }

  while (steps_.size() > done_) {
    forget(std::move(steps_.back().split));
    steps_.pop_back();
  }
  redo_steps_ = 0;
}

void SessionHistory::forget(std::unique_ptr<Split> split) noexcept {
  if (!split) return;
  split->next = std::move(forgotten_);
  forgotten_ = std::move(split);
}

// Makes its bricks permanent.
void SessionHistory::forgetOldest() noexcept {
  if (floor_ > 0) {
    --floor_;
  } else if (steps_.size() > 1 && steps_[1].joins_last) {  // undo still covers the rest of it
    steps_[1].what.number = steps_[0].what.number;
    steps_[1].what.origin = steps_[0].what.origin;
  } else {
    --undo_steps_;
    ++forgotten_steps_;
  }
  forget(std::move(steps_.front().split));
  steps_.erase(steps_.begin());
  --done_;
}

SessionHistory::Step& SessionHistory::addStep(std::vector<CutObject>& objects, bool joins_last) noexcept {
  forgetRedo(objects);
  if (done_ == kMostSteps) forgetOldest();
  Step& step = steps_.emplace_back();  // reserved
  step.joins_last = joins_last;
  step.what.origin = next_;
  if (beginsUndo(done_)) {
    step.what.number = ++made_;
    ++undo_steps_;
  }
  ++done_;
  return step;
}

void SessionHistory::mark(std::vector<CutObject>& objects) noexcept {
  assert(objects.size() == now_.size());
  Step& step = addStep(objects, joins_next_);
  joins_next_ = false;
  is_open_ = true;

  for (std::size_t n = 0; n < objects.size(); ++n) {
    CutObject& object = objects[n];
    TrackedState& known = now_[n];
    if (!object.strokes().isOpen() && isSamePose(known.pose, object.T_world_object)) continue;
    StrokeRecord* const record = object.memory().takeRecord();
    assert(record);
    if (!record) continue;

    record->object = n;
    record->bricks = object.strokes().end();
    record->pose_before = known.pose;
    record->before = known.ledger;
    known = trackedState(object);
    record->pose_after = known.pose;
    record->after = known.ledger;
    if (!record->bricks.isEmpty()) step.what.kind = UndoStep::Kind::kStroke;
    addTo(step.what, record->before, record->after);
    step.records.pushFront(record);
  }
}

void SessionHistory::split(std::vector<CutObject>& objects, std::size_t index, std::unique_ptr<Split> split) noexcept {
  assert(split && split->parts > 0 && objects.size() + split->parts - 1 <= kMostObjects);
  const bool joins_last = done_ > 0 && is_open_;
  Step& step = addStep(objects, joins_last);
  step.what.kind = split->is_plane_cut ? UndoStep::Kind::kPlaneCut : UndoStep::Kind::kStroke;
  step.what.removed_mm3 = split->lost_mm3;
  step.split = std::move(split);
  step.split->index = index;
  swapSplit(objects, *step.split, false);
  // Later cuts of the stroke that cut through belong to the same stroke.
  joins_next_ = true;
  is_open_ = true;
}

void SessionHistory::erase(std::vector<CutObject>& objects, std::uint64_t which, std::unique_ptr<Split> room) noexcept {
  assert(room && room->out_of_scene.empty() && room->out_of_scene.capacity() >= objects.size());
  Step& step = addStep(objects, false);
  step.what.kind = UndoStep::Kind::kDelete;
  room->deleted = which;

  // As loaded: material added to them was never a part of the object.
  std::array<double, 256>& before = room->heir_before;
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const CutObject& object = objects[n];
    if (!has(which, n)) continue;
    ++step.what.deleted;
    const std::array<double, 256> left = object.bricks().countVolumes();
    for (std::size_t m = 0; m < left.size(); ++m) {
      step.what.removed_mm3 += left[m];
      before[m] += object.removed_before_mm3[m] + object.removed_mm3[m] + std::max(left[m] - object.added_mm3[m], 0.0);
    }
    room->heir = n;
  }
  const BakedObject* const loaded = &objects[room->heir].baked();
  room->heir = 0;
  while (has(which, room->heir) || &objects[room->heir].baked() != loaded) ++room->heir;
  for (std::size_t m = 0; m < before.size(); ++m) before[m] += objects[room->heir].removed_before_mm3[m];

  room->lost_mm3 = step.what.removed_mm3;
  step.split = std::move(room);
  swapDeleted(objects, *step.split, false);
}

void SessionHistory::swapDeleted(std::vector<CutObject>& objects, Split& split, bool is_undo) noexcept {
  if (is_undo) {
    auto part = split.out_of_scene.begin();
    for (std::size_t n = 0; part != split.out_of_scene.end(); ++n) {
      if (!has(split.deleted, n)) continue;
      objects.insert(objects.begin() + static_cast<std::ptrdiff_t>(n), std::move(part->object));
      now_.insert(now_.begin() + static_cast<std::ptrdiff_t>(n), std::move(part->tracked));
      ++part;
    }
    split.out_of_scene.clear();
  }
  std::swap(objects[split.heir].removed_before_mm3, split.heir_before);
  if (!is_undo) {
    std::size_t kept = 0;
    for (std::size_t n = 0; n < objects.size(); ++n) {
      if (has(split.deleted, n)) {
        split.out_of_scene.push_back({std::move(objects[n]), std::move(now_[n])});
      } else if (kept++ != n) {
        objects[kept - 1] = std::move(objects[n]);
        now_[kept - 1] = std::move(now_[n]);
      }
    }
    objects.erase(objects.begin() + static_cast<std::ptrdiff_t>(kept), objects.end());
    now_.resize(kept);
  }
  for (CutObject& object : objects) object.wake();
}

void SessionHistory::swapSplit(std::vector<CutObject>& objects, Split& split, bool is_undo) noexcept {
  // Out of the scene: the whole, or for an undo all its parts.
  std::vector<Split::Part>& out = split.for_exchange;  // reserved, as objects and now_ are
  out.clear();
  out.push_back({std::move(objects[split.index]), std::move(now_[split.index])});
  if (is_undo) {
    const std::size_t first = objects.size() - (split.parts - 1);
    for (std::size_t n = first; n < objects.size(); ++n) out.push_back({std::move(objects[n]), std::move(now_[n])});
    objects.erase(objects.begin() + static_cast<std::ptrdiff_t>(first), objects.end());
    now_.resize(first);
  }

  // Into the scene: the first in its place, the others at the end.
  objects[split.index] = std::move(split.out_of_scene.front().object);
  now_[split.index] = std::move(split.out_of_scene.front().tracked);
  for (std::size_t n = 1; n < split.out_of_scene.size(); ++n) {
    objects.push_back(std::move(split.out_of_scene[n].object));
    now_.push_back(std::move(split.out_of_scene[n].tracked));
  }

  std::swap(split.out_of_scene, split.for_exchange);
  for (CutObject& object : objects) object.wake();
}

void SessionHistory::apply(std::vector<CutObject>& objects, Step& step, bool is_undo) noexcept {
  if (step.split && step.split->deleted != 0)
    swapDeleted(objects, *step.split, is_undo);
  else if (step.split)
    swapSplit(objects, *step.split, is_undo);
  for (const StrokeRecord* record = step.records.first; record; record = record->next) {
    CutObject& object = objects[record->object];
    object.swapStroke(record->bricks, is_undo);
    const Rigid3& pose = is_undo ? record->pose_before : record->pose_after;
    if (!isSamePose(object.T_world_object, pose)) object.moveTo(pose);
    const Ledger& ledger = is_undo ? record->before : record->after;
    object.removed_mm3 = ledger.removed;
    object.added_mm3 = ledger.added;
    now_[record->object] = {pose, ledger};
  }
}

bool SessionHistory::undo(std::vector<CutObject>& objects) noexcept {
  if (done_ == floor_) return false;
  joins_next_ = false;
  do apply(objects, steps_[--done_], true);
  while (steps_[done_].joins_last && done_ > floor_);
  --undo_steps_;
  ++redo_steps_;
  return true;
}

bool SessionHistory::redo(std::vector<CutObject>& objects) noexcept {
  if (done_ == steps_.size()) return false;
  do apply(objects, steps_[done_++], false);
  while (done_ < steps_.size() && steps_[done_].joins_last);
  ++undo_steps_;
  --redo_steps_;
  return true;
}

// Since the last mark.
UndoStep SessionHistory::changesOf(const std::vector<CutObject>& objects) const noexcept {
  UndoStep out;
  out.origin = next_;
  out.number = made_ + 1;
  for (std::size_t n = 0; n < objects.size(); ++n) {
    if (!objects[n].strokes().isOpen()) continue;
    out.kind = UndoStep::Kind::kStroke;
    addTo(out, now_[n].ledger, {objects[n].removed_mm3, objects[n].added_mm3});
  }
  return out;
}

UndoList SessionHistory::list(const std::vector<CutObject>& objects) const noexcept {
  UndoList out;
  out.forgotten = forgotten_steps_;
  out.undoable = undo_steps_;
  out.redoable = redo_steps_;
  const auto put = [&](const UndoStep& step) { out.newest[out.newest_count++] = step; };

  // From the last to the first.
  UndoStep joined;  // parts of the step that comes next
  std::size_t n = steps_.size();
  if (hasChanges(objects)) {
    const UndoStep changes = changesOf(objects);
    const bool joins_last = joins_next_ && done_ > floor_;
    joins_last ? addTo(joined, changes) : put(changes);
    out.undoable += joins_last ? 0 : 1;
    out.redoable = 0;
    n = done_;
  }
  while (n > floor_ && out.newest_count < out.newest.size()) {
    const UndoStep& part = steps_[--n].what;
    addTo(joined, part);
    if (!beginsUndo(n)) continue;
    joined.number = part.number;
    joined.origin = part.origin;
    put(joined);
    joined = {};
  }
  std::reverse(out.newest.begin(), out.newest.begin() + static_cast<std::ptrdiff_t>(out.newest_count));
  return out;
}

std::size_t SessionHistory::bytes() const noexcept {
  std::size_t versions = 0;
  for (const Step& step : steps_)
    for (const StrokeRecord* record = step.records.first; record; record = record->next)
      versions += record->bricks.count;
  return versions * sizeof(BrickVersion);
}

}  // namespace kerf
