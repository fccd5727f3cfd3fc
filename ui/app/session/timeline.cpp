#include "ui/app/session/timeline.h"
#include "ui/app/base/language.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

TimelineStep::Kind stepKind(UndoStep::Kind kind) {
  switch (kind) {
    case UndoStep::Kind::kMove:
      return TimelineStep::Kind::kMove;
    case UndoStep::Kind::kPlaneCut:
      return TimelineStep::Kind::kPlaneCut;
    case UndoStep::Kind::kDelete:
      return TimelineStep::Kind::kDelete;
    case UndoStep::Kind::kStroke:
      break;
  }
  return TimelineStep::Kind::kStroke;
}

}  // namespace

void Timeline::update(const UndoList& list) {
  if (list == list_) return;
  const std::uint64_t forgotten = list.forgotten - list_.forgotten;
  list_ = list;

  // Drops the oldest strokes for good.
  for (std::uint64_t n = 0; n < forgotten && !strokes_.empty(); ++n) {
    const PlannedCut* const cut = cutOf(strokes_.front().number);
    strokes_.erase(strokes_.begin());
    if (!cut || strokes_.empty() || cutOf(strokes_.front().number) != cut) ++older_;
  }
  if (forgotten > 0) groupSteps();
  const std::vector<UndoStep> strokes_then = strokes_;
  const std::vector<TimelineStep> steps_then = steps_;

  // Numbers rise: the list replaces all strokes from its first number on.
  const std::size_t count = list.undoable + list.redoable;
  const std::size_t before = count - std::min(count, list.newest_count);
  const auto newest_end = list.newest.begin() + static_cast<std::ptrdiff_t>(list.newest_count);
  const std::uint64_t first = list.newest_count > 0 ? list.newest[0].number : 0;
  std::erase_if(strokes_, [&](const UndoStep& known) { return known.number >= first; });
  // More strokes between two reports than a list holds: fills in unknown ones.
  strokes_.resize(before, UndoStep{.number = first - 1, .origin = {}, .kind = UndoStep::Kind::kStroke});
  strokes_.insert(strokes_.end(), list.newest.begin(), newest_end);

  if (!strokes_.empty()) newest_ = std::max(newest_, strokes_.back().number);
  keepDropped(strokes_then, steps_then);
  groupSteps();
}

// Numbers rise and are unique: a missing number with a newer one in its place was dropped.
void Timeline::keepDropped(const std::vector<UndoStep>& known, const std::vector<TimelineStep>& known_steps) {
  if (known.empty() || strokes_.empty() || strokes_.back().number <= known.back().number) return;
  std::size_t kept = 0;
  while (kept < known.size() && kept < strokes_.size() && known[kept].number == strokes_[kept].number) ++kept;
  if (kept < known.size()) branches_.push_back(branchBehind(kept, known, known_steps));
}

// Includes the whole of a planned cut that was undone in part.
TimelineBranch Timeline::branchBehind(std::size_t kept, const std::vector<UndoStep>& strokes,
                                      const std::vector<TimelineStep>& steps) const {
  std::size_t first = 0;
  for (std::size_t before = 0; first < steps.size() && before + steps[first].strokes <= kept; ++first)
    before += steps[first].strokes;

  TimelineBranch out;
  out.from = older_ + first;
  out.steps.assign(steps.begin() + static_cast<std::ptrdiff_t>(first), steps.end());
  out.last_began = strokes.back().origin.tick;
  return out;
}

std::optional<TimelineBranch> Timeline::ahead(std::size_t strokes) const {
  if (strokes >= strokes_.size()) return {};
  return branchBehind(strokes, strokes_, steps_);
}

void Timeline::beginPlannedCut(const std::string& plane) { cuts_.push_back({plane, newest_ + 1, 0}); }

void Timeline::endPlannedCut(const std::string& hole) {
  if (!cuts_.empty() && cuts_.back().last == 0) cuts_.back().last = newest_;
  if (!cuts_.empty() && cuts_.back().last < cuts_.back().first) return cuts_.pop_back();  // it cut nothing
  if (cuts_.empty() || hole.empty()) return;
  cuts_.back().plane = hole;
  cuts_.back().is_hole = true;
  groupSteps();
}

const Timeline::PlannedCut* Timeline::cutOf(std::uint64_t number) const {
  const auto cut = std::find_if(cuts_.begin(), cuts_.end(), [&](const PlannedCut& c) {
    return number >= c.first && (c.last == 0 || number <= c.last);
  });
  return cut == cuts_.end() ? nullptr : &*cut;
}

void Timeline::groupSteps() {
  steps_.clear();
  const PlannedCut* last_cut = nullptr;
  for (const UndoStep& stroke : strokes_) {
    const PlannedCut* const cut = stroke.kind != UndoStep::Kind::kStroke ? nullptr : cutOf(stroke.number);
    if (cut && cut == last_cut) {
      ++steps_.back().strokes;
    } else {
      TimelineStep& step = steps_.emplace_back();
      step.kind = stepKind(stroke.kind);
      if (cut) step.kind = cut->is_hole ? TimelineStep::Kind::kHole : TimelineStep::Kind::kPlannedCut;
      step.tool = stroke.origin.tool;
      step.plane = cut ? cut->plane : "";
      step.began_s = kTick * static_cast<double>(stroke.origin.tick);
    }
    steps_.back().removed_mm3 += stroke.removed_mm3;
    steps_.back().added_mm3 += stroke.added_mm3;
    steps_.back().deleted += stroke.deleted;
    last_cut = cut;
  }
}

std::size_t Timeline::doneAt(std::size_t strokes) const {
  std::size_t done = 0;
  for (; done < steps_.size() && steps_[done].strokes <= strokes; ++done) strokes -= steps_[done].strokes;
  return done;
}

std::size_t Timeline::strokesAt(std::size_t done) const {
  std::size_t strokes = 0;
  for (std::size_t n = 0; n < std::min(done, steps_.size()); ++n) strokes += steps_[n].strokes;
  return strokes;
}

Expected<std::size_t> Timeline::strokesAfter(std::uint64_t number) const {
  const std::uint64_t last = older_ + steps_.size();
  if (number < older_)
    return fail({.code = Error::Code::kUnsupported,
                 .found = fmt::format("step {} is no longer stored", number),
                 .expected = fmt::format("{} to {}", older_, last),
                 .hint = "go back to the earliest stored step with edit.begin"});
  if (number > last)
    return fail({.code = Error::Code::kBadValue,
                 .found = fmt::format("step {}", number),
                 .expected = fmt::format("{} to {}", older_, last)});
  return strokesAt(static_cast<std::size_t>(number - older_));
}

std::string describeStep(const TimelineStep& step, std::uint64_t number, const std::string& tool) {
  if (step.kind == TimelineStep::Kind::kMove) return phrase("{}: piece moved, at {:.1f} s", number, step.began_s);
  if (step.kind == TimelineStep::Kind::kDelete)
    return phrase("{}: {}, at {:.1f} s", number, deletedText(step.deleted, step.removed_mm3), step.began_s);
  const std::string what = step.kind == TimelineStep::Kind::kPlannedCut ? phrase("planned cut {}", step.plane)
                           : step.kind == TimelineStep::Kind::kHole     ? step.plane
                           : step.kind == TimelineStep::Kind::kPlaneCut ? shownText("plane cut")
                                                                        : tool;
  std::string out = phrase("{}: {}, {:.2f} mm3 removed", number, what, step.removed_mm3);
  if (step.added_mm3 > 0) out += phrase(", {:.2f} mm3 added", step.added_mm3);
  return out + phrase(", at {:.1f} s", step.began_s);
}

std::string deletedText(std::size_t pieces, double mm3) {
  return pieces == 1 ? phrase("1 piece deleted, {:.2f} mm3", mm3)
                     : phrase("{} pieces deleted, {:.2f} mm3", pieces, mm3);
}

std::string describeBranch(const TimelineBranch& branch) {
  double removed = 0;
  for (const TimelineStep& step : branch.steps) removed += step.removed_mm3;
  const std::string from = branch.from == 0 ? shownText("from the beginning") : phrase("from step {}", branch.from);
  const double last_s = kTick * static_cast<double>(branch.last_began);
  const std::size_t count = branch.steps.size();
  return count == 1 ? phrase("{}: 1 step, {:.2f} mm3 removed, at {:.1f} s", from, removed, last_s)
                    : phrase("{}: {} steps, {:.2f} mm3 removed, the last at {:.1f} s", from, count, removed, last_s);
}

std::string lossOf(std::size_t steps_ahead) {
  if (steps_ahead < 2) return {};
  return phrase("A new stroke from here makes the {} steps ahead a branch.", steps_ahead);
}

}  // namespace kerf
