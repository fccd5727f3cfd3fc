#include "sim/live/stroke_peaks.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

void raiseTo(CutPeaks::Peak& peak, const CutPeaks::Peak& other) noexcept {
  if (other.isKnown() && (!peak.isKnown() || other.value > peak.value)) peak = other;
}

void lowerTo(CutPeaks::Peak& peak, const CutPeaks::Peak& other) noexcept {
  if (other.isKnown() && (!peak.isKnown() || other.value < peak.value)) peak = other;
}

}  // namespace

void CutPeaks::add(const CutPeaks& other) noexcept {
  raiseTo(contact_N, other.contact_N);
  raiseTo(celsius, other.celsius);
  for (std::size_t n = 0; n < nearest_mm.size(); ++n) lowerTo(nearest_mm[n], other.nearest_mm[n]);
  contact_sum += other.contact_sum;
  ticks_in_contact += other.ticks_in_contact;
}

void StrokePeaks::tick(const DeviceSample& sample, const StepOutput& output, const UndoList& list, std::uint64_t tick,
                       double celsius, const Distances& distances) noexcept {
  const bool presses = sample.isUsable() && sample.pedal != 0;
  if (presses && !is_pressed_) beginStroke(tick);
  is_pressed_ = presses;
  follow(list);

  CutPeaks& now = at_ != kNone ? steps_[at_].peaks : stroke_;
  const double at_s = static_cast<double>(tick + 1) * kTick;
  const double force = output.contact.force.norm();
  raiseTo(now.contact_N, {force, at_s});
  if (output.touching > 0) {
    now.contact_sum += force;
    ++now.ticks_in_contact;
  }
  if (!std::isnan(celsius)) raiseTo(now.celsius, {celsius, at_s});
  for (std::size_t n = 0; n < distances.size(); ++n)
    if (!std::isnan(distances[n])) lowerTo(now.nearest_mm[n], {distances[n], at_s});
}

void StrokePeaks::follow(const UndoList& list) noexcept {
  for (; forgotten_ < list.forgotten; ++forgotten_) forgetOldest();
  const std::size_t count = list.undoable + list.redoable;
  const std::size_t before = count - std::min(count, list.newest_count);
  for (std::size_t n = 0; n < list.newest_count; ++n) {
    const std::size_t index = before + n;
    if (index < steps_.size() && steps_[index].number == list.newest[n].number) continue;
    dropFrom(index);
    while (steps_.size() < index) steps_.emplace_back();  // more than a list names, in one tick
    addStep(list.newest[n]);
  }
  dropFrom(count);
  done_ = list.undoable;
}

void StrokePeaks::beginStroke(std::uint64_t tick) noexcept {
  for_good_.add(stroke_);
  stroke_ = {};
  at_ = kNone;
  began_ = tick;
}

void StrokePeaks::addStep(const UndoStep& step) noexcept {
  steps_.push_back({step.number, {}});
  if (step.kind != UndoStep::Kind::kStroke || step.origin.tick < began_) return;
  if (step.origin.tick > began_) beginStroke(step.origin.tick);  // its pedal never came up
  if (at_ != kNone) return;
  at_ = steps_.size() - 1;
  steps_[at_].peaks = stroke_;
  stroke_ = {};
}

void StrokePeaks::dropFrom(std::size_t first) noexcept {
  for (std::size_t n = first; n < steps_.size(); ++n) dropped_.add(steps_[n].peaks);
  if (first < steps_.size()) steps_.resize(first);
  if (at_ != kNone && at_ >= first) at_ = kNone;
}

void StrokePeaks::forgetOldest() noexcept {
  if (steps_.empty()) return;
  for_good_.add(steps_.front().peaks);
  steps_.erase(steps_.begin());
  if (at_ != kNone) at_ = at_ > 0 ? at_ - 1 : kNone;
}

CutPeaks StrokePeaks::standing() const noexcept {
  CutPeaks out = for_good_;
  out.add(stroke_);
  for (std::size_t n = 0; n < done_; ++n) out.add(steps_[n].peaks);
  return out;
}

CutPeaks StrokePeaks::takenBack() const noexcept {
  CutPeaks out = dropped_;
  for (std::size_t n = done_; n < steps_.size(); ++n) out.add(steps_[n].peaks);
  return out;
}

}  // namespace kerf
