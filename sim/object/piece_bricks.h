// The bricks of one piece of an object.
#pragma once

#include <vector>

#include "sim/object/brick_edit.h"

namespace kerf {

/// The field of one piece as its difference from the whole: for an object that shares the rest with the whole.
struct PieceBricks {
  std::vector<Vec3i> bricks;       ///< with values, in order of coordinate
  std::vector<Vec3i> interior;     ///< constant and wholly inside, not in `bricks`, in order of coordinate
  std::vector<BrickEdit> changed;  ///< those of `bricks` near other pieces, in the same order, with their new values
  std::vector<Vec3i> at_edge;  ///< of `bricks`: all with a neighbour that the whole has and the piece lacks; maybe more
};

}  // namespace kerf
