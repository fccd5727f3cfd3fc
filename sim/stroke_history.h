// Undo and redo of strokes: what every stroke changed, brick by brick, before and after.
//
// For the thread that owns the object, between ticks; allocates. Marking a stroke compares the bricks changed so far,
// some microseconds each.
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "sim/cut_object.h"

namespace kerf {

class StrokeHistory {
 public:
  /// Something differs from the last mark.
  bool hasChanges(const CutObject& object) const;
  /// A stroke is over: what differs from the last mark is one step of undo, be it nothing. Forgets what could be
  /// redone. Where a session has several objects, all are marked together, so that one undo takes back one stroke.
  void mark(const CutObject& object);
  /// Takes back the last stroke. False: there is none, or memory ran out. @pre everything is marked.
  bool undo(CutObject& object);
  bool redo(CutObject& object);
  std::size_t undoable() const { return done_; }
  std::size_t redoable() const { return strokes_.size() - done_; }
  /// Bytes held.
  std::size_t bytes() const;

 private:
  using Values = std::shared_ptr<const BrickValues>;  // null: as baked
  struct Change {
    int slot;
    Values before, after;
  };
  using Stroke = std::vector<Change>;
  bool apply(CutObject& object, const Stroke& stroke, bool is_undo);

  std::unordered_map<int, Values> now_;  // of changed bricks, as of the last mark
  std::vector<Stroke> strokes_;
  std::size_t done_ = 0;  // of them, not taken back
};

}  // namespace kerf
