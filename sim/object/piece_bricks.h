// Which bricks of an object belong to one of its pieces.
#pragma once

#include <vector>

#include "sim/object/brick_edit.h"

namespace kerf {

/// The field of one piece, told by what differs from the whole: for an object that shares the rest with it.
struct PieceBricks {
  std::vector<Vec3i> bricks;       ///< with values, in order of coordinate
  std::vector<Vec3i> interior;     ///< wholly inside and constant, beside those, in order of coordinate
  std::vector<BrickEdit> changed;  ///< of `bricks`, those near other pieces, in the same order: their new values
  std::vector<Vec3i> at_edge;  ///< of `bricks`: no others have a neighbour that the whole has, and the piece has not
};

}  // namespace kerf
