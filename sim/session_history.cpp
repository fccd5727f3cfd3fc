#include "sim/session_history.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <unordered_set>

namespace kerf {
namespace {

bool isSamePose(const Rigid3& a, const Rigid3& b) {
  return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs();
}

}  // namespace

SessionHistory::KeptPtr SessionHistory::keep(const CutObject::Slot& slot) {
  auto out = std::make_shared<Kept>();
  std::copy_n(slot.own, kBrickNodes, out->phi.begin());
  out->has_own_materials = slot.own_materials != nullptr;
  std::copy_n(slot.materials, kBrickNodes, out->materials.begin());
  return out;
}

bool SessionHistory::isAsKept(const CutObject::Slot& slot, const KeptPtr& kept) {
  const float* phi = kept ? kept->phi.data() : slot.baked;
  if (std::memcmp(phi, slot.phi, sizeof(BrickValues)) != 0) return false;
  const std::uint8_t* materials = kept && kept->has_own_materials ? kept->materials.data() : slot.baked_materials;
  return materials == slot.materials || std::memcmp(materials, slot.materials, kBrickNodes) == 0;
}

SessionHistory::Tracked SessionHistory::track(const CutObject& object) {
  Tracked out;
  for (int s = 0; s < object.slotCount(); ++s)
    if (object.slot(s).own && !isAsKept(object.slot(s), nullptr)) out.bricks[s] = keep(object.slot(s));
  out.pose = object.T_world_object;
  out.ledger = {object.removed_mm3, object.added_mm3};
  return out;
}

SessionHistory::SessionHistory(const std::vector<CutObject>& objects) {
  for (const CutObject& object : objects) now_.push_back(track(object));
}

bool SessionHistory::hasChanges(const std::vector<CutObject>& objects) const {
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const Tracked& known = now_[n];
    if (!isSamePose(known.pose, objects[n].T_world_object)) return true;
    for (int s = 0; s < objects[n].slotCount(); ++s) {
      const CutObject::Slot& slot = objects[n].slot(s);
      if (!slot.own) continue;
      const auto kept = known.bricks.find(s);
      if (!isAsKept(slot, kept == known.bricks.end() ? nullptr : kept->second)) return true;
    }
  }
  return false;
}

void SessionHistory::mark(const std::vector<CutObject>& objects) {
  assert(objects.size() == now_.size());
  Step step;
  step.joins_last = joins_next_;
  joins_next_ = false;
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const CutObject& object = objects[n];
    Tracked& known = now_[n];
    ObjectChange& change = step.objects.emplace_back();
    for (int s = 0; s < object.slotCount(); ++s) {
      const CutObject::Slot& slot = object.slot(s);
      if (!slot.own) continue;
      KeptPtr& kept = known.bricks.try_emplace(s).first->second;
      if (isAsKept(slot, kept)) continue;
      KeptPtr after = keep(slot);
      change.bricks.push_back({s, kept, after});
      kept = std::move(after);
    }
    change.pose_before = known.pose, change.pose_after = known.pose = object.T_world_object;
    if (change.bricks.empty()) continue;
    change.before = std::make_shared<Ledger>(known.ledger);
    known.ledger = {object.removed_mm3, object.added_mm3};
    change.after = std::make_shared<Ledger>(known.ledger);
  }
  steps_.resize(done_);
  steps_.push_back(std::move(step));
  ++done_;
}

void SessionHistory::split(std::vector<CutObject>& objects, std::size_t index, std::vector<CutObject> parts) {
  assert(!parts.empty() && !joins_next_);
  steps_.resize(done_);
  Step& step = steps_.emplace_back();
  step.joins_last = done_ > 0;
  step.split.emplace();
  step.split->index = index, step.split->parts = parts.size();
  for (CutObject& part : parts) {
    Tracked tracked = track(part);
    step.split->held.push_back({std::move(part), std::move(tracked)});
  }
  swapSplit(objects, *step.split, false);
  ++done_;
  // What the stroke that cut through goes on to cut is still the same stroke.
  joins_next_ = true;
}

void SessionHistory::swapSplit(std::vector<CutObject>& objects, Split& split, bool is_undo) {
  std::vector<Held> held;
  held.push_back({std::move(objects[split.index]), std::move(now_[split.index])});
  if (is_undo) {
    const std::size_t first = objects.size() - (split.parts - 1);
    for (std::size_t n = first; n < objects.size(); ++n) held.push_back({std::move(objects[n]), std::move(now_[n])});
    objects.erase(objects.begin() + static_cast<std::ptrdiff_t>(first), objects.end());
    now_.resize(first);
  }
  objects[split.index] = std::move(split.held.front().object);
  now_[split.index] = std::move(split.held.front().tracked);
  for (std::size_t n = 1; n < split.held.size(); ++n) {
    objects.push_back(std::move(split.held[n].object));
    now_.push_back(std::move(split.held[n].tracked));
  }
  split.held = std::move(held);
  for (CutObject& object : objects) object.odometer += 1e6;
}

bool SessionHistory::apply(std::vector<CutObject>& objects, Step& step, bool is_undo) {
  if (step.split) {
    swapSplit(objects, *step.split, is_undo);
    return true;
  }
  // Room for all of it first: half an undo is worse than none.
  for (std::size_t n = 0; n < step.objects.size(); ++n)
    if (const std::size_t need = step.objects[n].bricks.size();
        objects[n].freeBricks() < need && !objects[n].reserve(need))
      return false;
  for (std::size_t n = 0; n < step.objects.size(); ++n) {
    const ObjectChange& change = step.objects[n];
    CutObject& object = objects[n];
    for (const BrickChange& brick : change.bricks) {
      const KeptPtr& wanted = is_undo ? brick.before : brick.after;
      const CutObject::Slot& slot = object.slot(brick.slot);
      BrickValues values;
      std::copy_n(wanted ? wanted->phi.data() : slot.baked, kBrickNodes, values.begin());
      if (!object.restore(brick.slot, values, wanted && wanted->has_own_materials ? wanted->materials.data() : nullptr))
        return false;
      now_[n].bricks[brick.slot] = wanted;
    }
    const Rigid3& pose = is_undo ? change.pose_before : change.pose_after;
    if (!isSamePose(object.T_world_object, pose)) object.moveTo(pose);
    now_[n].pose = pose;
    if (change.before) {
      const Ledger& ledger = is_undo ? *change.before : *change.after;
      object.removed_mm3 = ledger.removed, object.added_mm3 = ledger.added;
      now_[n].ledger = ledger;
    }
    while (!object.repair())
      if (!object.reserve(1024)) return false;
  }
  return true;
}

bool SessionHistory::undo(std::vector<CutObject>& objects) {
  if (done_ == 0) return false;
  joins_next_ = false;
  while (true) {
    Step& step = steps_[done_ - 1];
    if (!apply(objects, step, true)) return false;
    --done_;
    if (!step.joins_last || done_ == 0) return true;
  }
}

bool SessionHistory::redo(std::vector<CutObject>& objects) {
  if (done_ == steps_.size()) return false;
  do {
    if (!apply(objects, steps_[done_], false)) return false;
    ++done_;
  } while (done_ < steps_.size() && steps_[done_].joins_last);
  return true;
}

std::size_t SessionHistory::bytes() const {
  std::unordered_set<const Kept*> held;
  for (const Step& step : steps_)
    for (const ObjectChange& object : step.objects)
      for (const BrickChange& change : object.bricks) held.insert(change.before.get()), held.insert(change.after.get());
  held.erase(nullptr);
  return held.size() * sizeof(Kept);
}

}  // namespace kerf
