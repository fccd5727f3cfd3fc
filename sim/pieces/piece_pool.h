// Memory for the pieces of an object, prepared before the split.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "sim/object/cut_object.h"
#include "sim/pieces/piece_origin.h"
#include "sim/pieces/split_pool.h"

namespace kerf {

/// Memory for two pieces, the usual number: the user waits for a split, and new memory is slow to come.
struct PiecePool {
  std::vector<std::unique_ptr<CutObject>> blanks;  ///< for the first pieces: blankPiece()
  std::vector<std::vector<BrickEdit>> cuts;        ///< for their PieceOrigin::cut
  SplitPool lists;

  /// For two pieces of the finder's current field, each with at least `bricks` free bricks. Makes missing memory with a
  /// reserve. @cost 0.9 to 1.1 s for a mandible of 148 000 bricks with all memory locked, the first time and after each
  /// split; 3 us when nothing is missing.
  void reserve(const std::shared_ptr<const BakedObject>& baked, const PieceFinder& finder, std::size_t bricks);
  /// Copies a piece's origin into memory of just the needed size, and takes back the memory of `origin`.
  std::shared_ptr<const PieceOrigin> takeBack(PieceOrigin& origin);
};

}  // namespace kerf
