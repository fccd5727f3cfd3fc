// What strokes change: versions of bricks, and the record of one stroke.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/base/types.h"
#include "geometry/field/brick_field.h"
#include "sim/object/linked_list.h"

namespace kerf {

/// What a brick is during one stroke. A brick that changes in a later stroke gets another version. The one before stays
/// as it is, so that undo and redo are a change of pointers.
struct BrickVersion {
  BrickValues phi;
  std::array<std::uint8_t, kBrickNodes> materials;  ///< if has_own_materials; else those baked count
  BrickVersion* before;                             ///< what the brick was before the stroke; null: as baked
  BrickVersion* next;                               ///< in the list it is in: free ones, or those of its stroke
  std::uint64_t stroke;                             ///< in which it was made
  int slot;                                         ///< of the brick
  bool has_own_materials;
};

/// What an object has lost and gained, mm^3 per material number.
struct Ledger {
  std::array<double, 256> removed{}, added{};
};

/// What one stroke did to one object.
struct StrokeRecord {
  std::size_t object = 0;  ///< its index
  LinkedList<BrickVersion> bricks;
  Rigid3 pose_before, pose_after;
  Ledger before, after;
  StrokeRecord* next = nullptr;
};

}  // namespace kerf
