// The steps of a session that can be taken back or done again, and where now is among them.
//
// It follows the UndoList of each report. A list names the last steps only; those before are kept from earlier ones. A
// planned cut is one step, however many strokes the 1 kHz thread made of it. Steps that were taken back, and in whose
// place others came, are a branch. On the window's thread; no clock, no file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "sim/live/haptic_thread.h"

namespace kerf {

struct TimelineStep {
  enum class Kind { kStroke, kMove, kPlannedCut };
  Kind kind = Kind::kStroke;
  std::size_t tool = 0;  ///< in hand when it began
  std::string plane{};   ///< of a planned cut
  double began_s = 0;    ///< since the session began, by its own clock
  double removed_mm3 = 0, added_mm3 = 0;
  std::size_t strokes = 1;  ///< so many Undo take it back
};

/// Steps that were taken back, and then others came in their place. The log of the session still has them.
struct TimelineBranch {
  std::uint64_t from = 0;           ///< number of the step behind which they stood; 0: the beginning
  std::vector<TimelineStep> steps;  ///< the oldest first
  std::uint64_t last_began = 0;     ///< tick at which the last stroke among them began: BranchPoint::step_began
};

class Timeline {
 public:
  /// Something else was opened.
  void clear() { *this = {}; }
  void update(const UndoList& list);

  /// What is cut from here to endPlannedCut() is one step.
  void beginPlannedCut(const std::string& plane);
  void endPlannedCut();

  /// What can be taken back or done again, the oldest first.
  const std::vector<TimelineStep>& steps() const { return steps_; }
  /// So many of steps() are done, the others were taken back.
  std::size_t done() const { return doneAt(list_.undoable); }
  /// Steps before the first of steps(): too old to be taken back. For people step n of steps() is the one of number
  /// older() + n + 1.
  std::uint64_t older() const { return older_; }
  /// In the order in which they were dropped.
  const std::vector<TimelineBranch>& branches() const { return branches_; }
  /// What is taken back when so many strokes are done, as if others came in its place. None: nothing is.
  std::optional<TimelineBranch> ahead(std::size_t strokes) const;

  // Strokes, as Undo and Redo count them.

  /// Of those that can be undone, in the last report.
  std::size_t strokesDone() const { return list_.undoable; }
  /// So many steps are done when so many strokes are.
  std::size_t doneAt(std::size_t strokes) const;
  /// Strokes that are done when so many steps are.   @param done  0 to steps().size().
  std::size_t strokesAt(std::size_t done) const;
  /// The same for the number of a step, 0: before the first.
  /// Errors: kUnsupported below older(), kBadValue for a step that is not there.
  Expected<std::size_t> strokesAfter(std::uint64_t number) const;

 private:
  struct PlannedCut {
    std::string plane;
    std::uint64_t first = 0, last = 0;  // numbers of steps of undo; last 0: it goes on
  };
  const PlannedCut* cutOf(std::uint64_t number) const;
  void groupSteps();
  TimelineBranch branchBehind(std::size_t kept, const std::vector<UndoStep>& strokes,
                              const std::vector<TimelineStep>& steps) const;
  void keepDropped(const std::vector<UndoStep>& known, const std::vector<TimelineStep>& known_steps);

  UndoList list_;
  std::vector<UndoStep> strokes_;  // all that can be undone or redone, by rising numbers
  std::vector<TimelineStep> steps_;
  std::vector<PlannedCut> cuts_;
  std::vector<TimelineBranch> branches_;
  std::uint64_t newest_ = 0;  // number
  std::uint64_t older_ = 0;
};

/// "3: round-014, 0.42 mm3 removed, at 12.3 s".   @param number  older() + n + 1.   @param tool  its name.
std::string describeStep(const TimelineStep& step, std::uint64_t number, const std::string& tool);
/// "from step 2: 3 steps, 0.42 mm3 removed, the last at 12.3 s".
std::string describeBranch(const TimelineBranch& branch);
/// What becomes of the steps ahead with a stroke from an earlier place; empty if that is one step or none.
std::string lossOf(std::size_t steps_ahead);

}  // namespace kerf
