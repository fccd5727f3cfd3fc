// State of a piece at its split.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sim/object/baked_object.h"
#include "sim/object/brick_edit.h"
#include "sim/object/cut_object.h"

namespace kerf {

/// An object at its split: any thread can later build its field, mesh it and find its own pieces.
struct PieceOrigin {
  std::uint32_t id = 0, of = 0;  ///< CutObject::id of the piece and of its parent
  std::shared_ptr<const BakedObject> baked;
  PlaneSides plane_sides;                   ///< CutObject::plane_sides
  std::vector<Vec3i> bricks, interior;      ///< its bricks: with values, and constant
  std::vector<BrickEdit> cut, near_others;  ///< differences from `baked`, in disjoint lists
  /// Allocates 2 KB a brick with values.
  BrickField field() const;
};

/// Origin of a piece in the scene, in its current state.   @param piece  with CutObject::bricks().isPiece().
PieceOrigin originOf(const CutObject& piece);

}  // namespace kerf
