// Undo and redo of a session: what every stroke changed, brick by brick, before and after; moves and splits of objects.
//
// For the thread that owns the objects, between ticks; allocates. Marking compares the bricks changed so far, some
// microseconds each.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "sim/cut_object.h"

namespace kerf {

class SessionHistory {
 public:
  /// @param objects  those of the session, as they are now: what undo leads back to at last.
  explicit SessionHistory(const std::vector<CutObject>& objects);

  /// Something differs from the last mark.
  bool hasChanges(const std::vector<CutObject>& objects) const;
  /// What differs from the last mark is one step of undo, be it nothing. Forgets what could be redone.
  void mark(const std::vector<CutObject>& objects);
  /// Puts `parts` in the place of objects[index]: the first there, the others at the end. A step of its own, undone
  /// together with the one marked before it. @pre everything is marked; objects has the capacity.
  void split(std::vector<CutObject>& objects, std::size_t index, std::vector<CutObject> parts);
  /// What follows is a stroke of its own. (What is cut after a split and before this belongs to the stroke before.)
  void close() { joins_next_ = false; }
  /// Takes back the last stroke. False: there is none, or memory ran out. @pre everything is marked.
  bool undo(std::vector<CutObject>& objects);
  bool redo(std::vector<CutObject>& objects);
  std::size_t undoable() const { return done_; }
  std::size_t redoable() const { return steps_.size() - done_; }
  /// Bytes held in bricks.
  std::size_t bytes() const;

 private:
  struct Kept {  // a brick at some time
    BrickValues phi;
    std::array<std::uint8_t, kBrickNodes> materials;
    bool has_own_materials;
  };
  using KeptPtr = std::shared_ptr<const Kept>;  // null: as baked
  struct Ledger {
    std::array<double, 256> removed{}, added{};
  };
  struct Tracked {  // an object as of the last mark
    std::unordered_map<int, KeptPtr> bricks;
    Rigid3 pose;
    Ledger ledger;
  };
  struct BrickChange {
    int slot;
    KeptPtr before, after;
  };
  struct ObjectChange {
    std::vector<BrickChange> bricks;
    Rigid3 pose_before, pose_after;
    std::shared_ptr<const Ledger> before, after;
  };
  struct Held {
    CutObject object;
    Tracked tracked;
  };
  struct Split {
    std::size_t index = 0, parts = 0;
    std::vector<Held> held;  // the whole while it is split, the parts while that is taken back
  };
  struct Step {
    std::vector<ObjectChange> objects;
    std::optional<Split> split;
    bool joins_last = false;  // undone together with the step before it
  };

  static Tracked track(const CutObject& object);
  static KeptPtr keep(const CutObject::Slot& slot);
  static bool isAsKept(const CutObject::Slot& slot, const KeptPtr& kept);
  bool apply(std::vector<CutObject>& objects, Step& step, bool is_undo);
  void swapSplit(std::vector<CutObject>& objects, Split& split, bool is_undo);

  std::vector<Tracked> now_;  // one an object
  std::vector<Step> steps_;
  std::size_t done_ = 0;  // of them, not taken back
  bool joins_next_ = false;
};

}  // namespace kerf
