// Undo and redo of a session: which versions of which bricks belong to each stroke; moves and splits of objects.
//
// For the thread that owns the objects, between ticks. A brick that changes in a stroke gets a version of its own out
// of the object's pool (CutObject::write). So ending a stroke, and dropping steps to redo, costs a few pointers: no
// allocation, no lock. Undo and redo themselves take time with the stroke's size.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/object/cut_object.h"
#include "sim/pieces/split_record.h"

namespace kerf {

/// Begin and tool of an undo step.
struct StepOrigin {
  std::uint64_t tick = 0;
  std::size_t tool = 0;  ///< index into Model::tools
  bool operator==(const StepOrigin&) const = default;
};

/// One undo step: a stroke with its splits, a plane cut, the move of an object, or a deletion.
struct UndoStep {
  enum class Kind : std::uint8_t { kStroke, kMove, kPlaneCut, kDelete };
  std::uint64_t number = 0;  ///< 1 is the first of the session; numbers increase and never repeat
  StepOrigin origin;
  Kind kind = Kind::kMove;
  double removed_mm3 = 0, added_mm3 = 0;
  std::size_t deleted = 0;  ///< objects
  bool operator==(const UndoStep&) const = default;
};

/// Steps for undo and redo: their numbers, and the last of them. A value of fixed size.
struct UndoList {
  static constexpr std::size_t kMostNewest = 8;

  std::size_t undoable = 0, redoable = 0;  ///< possible Undo, Redo commands now
  std::uint64_t forgotten = 0;             ///< steps too old for undo: kMostSteps
  std::array<UndoStep, kMostNewest> newest{};
  std::size_t newest_count = 0;  ///< of `newest`: the last of all steps, those to redo included, oldest first
  bool operator==(const UndoList&) const = default;
};

class SessionHistory {
 public:
  /// @param objects  of the session, now: the state before the first step.
  explicit SessionHistory(std::vector<CutObject>& objects);

  /// Bricks or poses changed since the last mark. @rt
  bool hasChanges(const std::vector<CutObject>& objects) const noexcept;
  /// Makes one undo step of all changes since the last mark, even if there are none. Forgets the steps to redo. @rt
  /// @pre every object has a free record; without one its part of the stroke stays for the next mark.
  void mark(std::vector<CutObject>& objects) noexcept;
  /// Replaces objects[index] by the parts: the first there, the others at the end. A step of its own, undone together
  /// with the one marked before it, unless close() lies between. @pre everything is marked; not more than kMostObjects
  /// result. @rt
  void split(std::vector<CutObject>& objects, std::size_t index, std::unique_ptr<Split> split) noexcept;
  /// Removes objects from the scene. A step of its own. @pre everything is marked, and close() was called; another
  /// piece of their loaded object stays. @param room  of prepareDeletion(). @rt but for the volumes: 1 us a brick.
  void erase(std::vector<CutObject>& objects, std::uint64_t which, std::unique_ptr<Split> room) noexcept;
  /// Splits beyond undo and redo, for destruction by another thread. @rt
  std::unique_ptr<Split> takeForgotten() noexcept { return std::move(forgotten_); }
  /// Starts a new stroke with the next change. Changes after a split and before this call belong to the stroke before.
  void close(const StepOrigin& next = {}) noexcept {
    joins_next_ = false;
    is_open_ = false;
    next_ = next;
  }
  /// Undoes, redoes the last stroke. False: there is none. The objects' next repair() mends the shells; it may need
  /// more bricks than are free. No allocation. @pre everything is marked.
  /// @cost 4 µs a brick; repair() takes 3 to 5 µs a brick more.
  bool undo(std::vector<CutObject>& objects) noexcept;
  bool redo(std::vector<CutObject>& objects) noexcept;
  /// Strokes and splits, each counted: an undo may take several of them.
  std::size_t undoable() const noexcept { return done_ - floor_; }
  /// Steps for undo and redo, including the changes since the last mark. @rt  @cost below 1 µs.
  UndoList list(const std::vector<CutObject>& objects) const noexcept;
  /// Makes all steps so far permanent. @pre everything is marked; nothing can be redone.
  void keepForGood() noexcept {
    floor_ = done_;
    undo_steps_ = 0;
  }
  std::size_t redoable() const noexcept { return steps_.size() - done_; }
  /// Bytes of the kept brick versions.
  std::size_t bytes() const noexcept;

  /// Most strokes and splits to undo; older ones are forgotten.
  static constexpr std::size_t kMostSteps = 16384;

 private:
  struct Step {
    LinkedList<StrokeRecord> records;  // of the changed objects; in their pools
    std::unique_ptr<Split> split;
    bool joins_last = false;  // undone together with the step before it
    UndoStep what;            // number and origin: of the first of those that are undone together
  };

  void forgetRedo(std::vector<CutObject>& objects) noexcept;
  void forget(std::unique_ptr<Split> split) noexcept;
  Step& addStep(std::vector<CutObject>& objects, bool joins_last) noexcept;
  void forgetOldest() noexcept;
  bool beginsUndo(std::size_t n) const noexcept { return n == floor_ || !steps_[n].joins_last; }
  UndoStep changesOf(const std::vector<CutObject>& objects) const noexcept;
  void apply(std::vector<CutObject>& objects, Step& step, bool is_undo) noexcept;
  void swapSplit(std::vector<CutObject>& objects, Split& split, bool is_undo) noexcept;
  void swapDeleted(std::vector<CutObject>& objects, Split& split, bool is_undo) noexcept;

  std::vector<TrackedState> now_;  // one an object
  std::vector<Step> steps_;
  std::size_t done_ = 0;   // of them, not undone
  std::size_t floor_ = 0;  // undo leads back to these
  bool joins_next_ = false;
  bool is_open_ = false;  // something was marked since close()
  StepOrigin next_;       // of the next change
  std::uint64_t made_ = 0, forgotten_steps_ = 0;
  std::size_t undo_steps_ = 0, redo_steps_ = 0;
  std::unique_ptr<Split> forgotten_;
};

}  // namespace kerf
