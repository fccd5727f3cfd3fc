// Undo and redo of steps, the timeline, and branches: lines of cutting that were left for another one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "sim/run/session/run_branch.h"
#include "ui/app/document/part.h"
#include "ui/app/session/timeline.h"

namespace kerf {

class Workbench;
struct EndedSession;

/// Another line of cutting, kept as a run or in the log of one.
struct Branch {
  std::filesystem::path run;
  BranchPoint point{};  ///< in its log; if neither is set: the end of the log
  std::string text;     ///< shown to the user
};

/// Window thread only.
class Steps final : public Part {
 public:
  explicit Steps(Workbench& bench) : bench_(bench) {}

  void undo();
  void redo();
  /// Undoes or redoes all steps between now and the end of a step. 0: the beginning. Blocks cutting until then.
  /// @param step  its number as displayed.
  /// Errors: kUnsupported for a step before timeline().older(), or during a plane cut; kBadValue for an unknown step.
  Expected<void> goToStep(std::uint64_t step);
  const Timeline& timeline() const { return timeline_; }
  /// Number of steps done once all requested Undo and Redo are: timeline().steps() up to there.
  std::size_t done() const;
  /// Undo, redo or a way to a step is under way.
  bool isMoving() const { return undos_left_ != 0 || wish_; }
  /// Every Undo and Redo sent is answered: the numbers of the objects in the scene are those of the simulation.
  bool isSettled() const;
  /// A way to a step waits for earlier commands.
  bool isWaiting() const { return wish_.has_value(); }
  /// Undo and Redo that are not sent to the 1 kHz thread yet: positive Redo, negative Undo.
  std::ptrdiff_t undosLeft() const { return undos_left_; }

  /// Branches beside the current line: steps undone before a new cut, in this session and in those it continues by a
  /// branch, a tool or a neighbour; and lines left for a branch.
  std::vector<Branch> branches() const;
  std::size_t branchCount() const { return left_.size() + timeline_.branches().size(); }
  /// Continues a branch in a new session. Writes the open session, which becomes a branch. A job.
  /// Errors: kEmpty; kBadValue for an unknown branch; kUnsupported during a plane cut.
  Expected<void> takeBranch(std::size_t n);

  // ---- For other parts

  /// All cutting until endPlannedCut() is one step.
  void beginPlannedCut(const std::string& plane) { timeline_.beginPlannedCut(plane); }
  void endPlannedCut(const std::string& hole = {}) { timeline_.endPlannedCut(hole); }
  /// Undone steps of the session: BranchPoint::step_began.   @param with_ahead  also those ahead of the present step.
  std::vector<std::uint64_t> droppedSteps(bool with_ahead) const;
  /// The session has ended: its branches move to the runs that keep them.
  void sessionEnded(const EndedSession& ended, const std::filesystem::path& folder);
  /// The branch where its steps are now. An empty run: they are gone.   @param gone  folder of a deleted session.
  Branch savedOf(const Branch& branch, const std::filesystem::path& gone) const;
  /// The open session continues a branch.   @param text  of the branch.
  void continuesBranch(const std::string& text);

  void opened(Opening how) override;
  void closing() override;
  void update() override;

 private:
  Expected<void> requireIdleSaw() const;
  void undoOrRedo(std::ptrdiff_t strokes);
  void sendUndos();
  void goWhereWished();
  std::size_t strokesDone() const;
  std::optional<Branch> lineNow() const;

  Workbench& bench_;
  Timeline timeline_;
  std::vector<Branch> left_;                              // branches of sessions that ended before this one
  std::optional<Branch> opened_;                          // continued by this session
  std::map<std::uint64_t, std::filesystem::path> saved_;  // EndedSession::saved of the last session
  struct Wish {
    std::uint64_t step = 0;
    std::uint64_t tick = 0;  // first tick that counts the stroke ended for the wish
  };
  std::optional<Wish> wish_;             // of goToStep(), until all earlier commands are done
  std::ptrdiff_t undos_left_ = 0;        // not yet sent: positive Redo, negative Undo
  std::ptrdiff_t strokes_then_ = 0;      // strokes done after them
  std::uint64_t undos_answered_at_ = 0;  // when so many commands are answered
};

}  // namespace kerf
