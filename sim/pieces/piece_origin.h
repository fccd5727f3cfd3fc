// What a piece was when it came off.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sim/object/baked_object.h"
#include "sim/object/brick_edit.h"
#include "sim/object/cut_object.h"

namespace kerf {

/// An object as it came off: enough to build its field, mesh it and find its own pieces later, by any thread.
struct PieceOrigin {
  std::uint32_t id = 0, of = 0;  ///< CutObject::id of the piece, and of what it was a piece of
  std::shared_ptr<const BakedObject> baked;
  std::vector<Vec3i> bricks, interior;      ///< that it has: with values, and constant
  std::vector<BrickEdit> cut, near_others;  ///< what differs from `baked`: none in both
  /// 2 KB a brick with values.
  BrickField field() const;
};

/// Of a piece that is in the scene already, as it is now.   @param piece  CutObject::bricks().isPiece().
PieceOrigin originOf(const CutObject& piece);

}  // namespace kerf
