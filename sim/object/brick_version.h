// Changes by strokes: versions of bricks, and the record of one stroke.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/base/types.h"
#include "geometry/field/brick_field.h"
#include "sim/object/linked_list.h"

namespace kerf {

/// State of a brick during one stroke. A later stroke makes another version and leaves this one unchanged, so that undo
/// and redo only change pointers.
struct BrickVersion {
  BrickValues phi;
  std::array<std::uint8_t, kBrickNodes> materials;  ///< valid if has_own_materials; else the baked ones count
  BrickVersion* before;                             ///< state before the stroke; null: as baked
  BrickVersion* next;                               ///< in its list: free versions, or those of its stroke
  std::uint64_t stroke;                             ///< of its making
  int slot;                                         ///< of the brick
  bool has_own_materials;
};

/// Volume that an object has lost and gained, mm^3 per material number.
struct Ledger {
  std::array<double, 256> removed{}, added{};
};

/// Effect of one stroke on one object.
struct StrokeRecord {
  std::size_t object = 0;  ///< its index
  LinkedList<BrickVersion> bricks;
  Rigid3 pose_before, pose_after;
  Ledger before, after;
  StrokeRecord* next = nullptr;
};

}  // namespace kerf
