// The steps of a session for undo and redo, and the present position among them.
//
// It follows the UndoList of each report. A list names only the last steps; earlier ones come from previous lists. A
// planned cut is one step, however many strokes the 1 kHz thread made of it. Undone steps replaced by others are a
// branch. On the window's thread; no clock, no file.
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
  enum class Kind { kStroke, kMove, kPlannedCut, kHole, kPlaneCut, kDelete };
  Kind kind = Kind::kStroke;
  std::size_t tool = 0;  ///< in hand at its start
  std::string plane{};   ///< of a planned cut; of a hole: its name and size
  double began_s = 0;    ///< since the start of the session, by its own clock
  double removed_mm3 = 0, added_mm3 = 0;
  std::size_t deleted = 0;  ///< pieces
  std::size_t strokes = 1;  ///< number of Undo that reverse it
};

/// Undone steps that others replaced. The session's log still has them.
struct TimelineBranch {
  std::uint64_t from = 0;           ///< number of the step before them; 0: the beginning
  std::vector<TimelineStep> steps;  ///< oldest first
  std::uint64_t last_began = 0;     ///< start tick of the last stroke among them: BranchPoint::step_began
};

class Timeline {
 public:
  /// To call when another document is opened.
  void clear() { *this = {}; }
  void update(const UndoList& list);

  /// All cutting from here to endPlannedCut() is one step.
  void beginPlannedCut(const std::string& plane);
  /// @param hole  name and size, if it is one.
  void endPlannedCut(const std::string& hole = {});

  /// Steps that can be undone or redone, oldest first.
  const std::vector<TimelineStep>& steps() const { return steps_; }
  /// Number of steps() that are done; the others are undone.
  std::size_t done() const { return doneAt(list_.undoable); }
  /// Number of steps before steps(): too old for undo. steps()[n] is displayed as number older() + n + 1.
  std::uint64_t older() const { return older_; }
  /// In the order of dropping.
  const std::vector<TimelineBranch>& branches() const { return branches_; }
  /// The branch that a new cut after so many strokes would drop. None: no undone steps.
  std::optional<TimelineBranch> ahead(std::size_t strokes) const;

  // Strokes, as Undo and Redo count them.

  /// Number of strokes that can be undone, in the last report.
  std::size_t strokesDone() const { return list_.undoable; }
  /// Number of steps done after so many strokes.
  std::size_t doneAt(std::size_t strokes) const;
  /// Number of strokes done after so many steps.   @param done  0 to steps().size().
  std::size_t strokesAt(std::size_t done) const;
  /// The same for the number of a step, 0: before the first.
  /// Errors: kUnsupported below older(), kBadValue for an unknown step.
  Expected<std::size_t> strokesAfter(std::uint64_t number) const;

 private:
  struct PlannedCut {
    std::string plane;
    std::uint64_t first = 0, last = 0;  // numbers of undo steps; last 0: it goes on
    bool is_hole = false;
  };
  const PlannedCut* cutOf(std::uint64_t number) const;
  void groupSteps();
  TimelineBranch branchBehind(std::size_t kept, const std::vector<UndoStep>& strokes,
                              const std::vector<TimelineStep>& steps) const;
  void keepDropped(const std::vector<UndoStep>& known, const std::vector<TimelineStep>& known_steps);

  UndoList list_;
  std::vector<UndoStep> strokes_;  // all that can be undone or redone, in rising order
  std::vector<TimelineStep> steps_;
  std::vector<PlannedCut> cuts_;
  std::vector<TimelineBranch> branches_;
  std::uint64_t newest_ = 0;  // number
  std::uint64_t older_ = 0;
};

/// "3: round-014, 0.42 mm3 removed, at 12.3 s".   @param number  older() + n + 1.   @param tool  its name.
std::string describeStep(const TimelineStep& step, std::uint64_t number, const std::string& tool);
/// "2 pieces deleted, 812.00 mm3"
std::string deletedText(std::size_t pieces, double mm3);
/// "from step 2: 3 steps, 0.42 mm3 removed, the last at 12.3 s".
std::string describeBranch(const TimelineBranch& branch);
/// Effect of a stroke from an earlier place on the steps ahead; empty for one step or none.
std::string lossOf(std::size_t steps_ahead);

}  // namespace kerf
