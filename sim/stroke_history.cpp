#include "sim/stroke_history.h"

#include <algorithm>
#include <cstring>
#include <unordered_set>

namespace kerf {

bool StrokeHistory::hasChanges(const CutObject& object) const {
  for (int s = 0; s < object.slotCount(); ++s) {
    const CutObject::Slot& slot = object.slot(s);
    if (!slot.own) continue;
    const auto known = now_.find(s);
    const float* old = known != now_.end() && known->second ? known->second->data()
                                                            : object.baked().slots()[static_cast<std::size_t>(s)].phi;
    if (std::memcmp(old, slot.own, sizeof(BrickValues)) != 0) return true;
  }
  return false;
}

void StrokeHistory::mark(const CutObject& object) {
  Stroke stroke;
  for (int s = 0; s < object.slotCount(); ++s) {
    const CutObject::Slot& slot = object.slot(s);
    if (!slot.own) continue;
    const auto known = now_.find(s);
    const Values before = known == now_.end() ? nullptr : known->second;
    const float* old = before ? before->data() : object.baked().slots()[static_cast<std::size_t>(s)].phi;
    if (std::memcmp(old, slot.own, sizeof(BrickValues)) == 0) continue;
    auto after = std::make_shared<BrickValues>();
    std::copy_n(slot.own, kBrickNodes, after->begin());
    stroke.push_back({s, before, after});
    now_[s] = after;
  }
  strokes_.resize(done_);
  strokes_.push_back(std::move(stroke));
  ++done_;
}

bool StrokeHistory::apply(CutObject& object, const Stroke& stroke, bool is_undo) {
  // Room for all of it first: half an undo is worse than none.
  if (object.freeBricks() < stroke.size() && !object.reserve(stroke.size())) return false;
  for (const Change& change : stroke) {
    const Values& wanted = is_undo ? change.before : change.after;
    BrickValues values;
    const float* from = wanted ? wanted->data() : object.baked().slots()[static_cast<std::size_t>(change.slot)].phi;
    std::copy_n(from, kBrickNodes, values.begin());
    if (!object.restore(object.slot(change.slot).brick, values)) return false;
    now_[change.slot] = wanted;
  }
  while (!object.repair())
    if (!object.reserve(1024)) return false;
  return true;
}

bool StrokeHistory::undo(CutObject& object) {
  if (done_ == 0 || !apply(object, strokes_[done_ - 1], true)) return false;
  --done_;
  return true;
}

bool StrokeHistory::redo(CutObject& object) {
  if (done_ == strokes_.size() || !apply(object, strokes_[done_], false)) return false;
  ++done_;
  return true;
}

std::size_t StrokeHistory::bytes() const {
  std::unordered_set<const BrickValues*> held;
  for (const Stroke& stroke : strokes_)
    for (const Change& change : stroke) held.insert(change.before.get()), held.insert(change.after.get());
  return held.size() * sizeof(BrickValues);
}

}  // namespace kerf
