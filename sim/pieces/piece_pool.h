// What the pieces of an object are made in, beforehand.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "sim/object/cut_object.h"
#include "sim/pieces/piece_origin.h"
#include "sim/pieces/split_pool.h"

namespace kerf {

/// Memory for two pieces, as most objects split into: they are waited for, and new memory is slow to come.
struct PiecePool {
  std::vector<std::unique_ptr<CutObject>> blanks;  ///< for the first pieces: blankPiece()
  std::vector<std::vector<BrickEdit>> cuts;        ///< for their PieceOrigin::cut
  SplitPool lists;

  /// For two pieces of what the finder has now, each with `bricks` free at least. Makes what is missing, and more than
  /// that. @cost 0.9 to 1.1 s for a mandible of 148 000 bricks with all memory locked, the first time and after each
  /// split; 3 us when nothing is missing.
  void reserve(const std::shared_ptr<const BakedObject>& baked, const PieceFinder& finder, std::size_t bricks);
  /// A copy of what a piece came off as, as large as it must be; the memory of the other comes back.
  std::shared_ptr<const PieceOrigin> takeBack(PieceOrigin& origin);
};

}  // namespace kerf
