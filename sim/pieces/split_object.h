// Results of splitting an object: any thread prepares them, the cutting thread puts them in place.
#pragma once

#include <memory>
#include <vector>

#include "sim/pieces/piece_pool.h"
#include "sim/pieces/split_record.h"

namespace kerf {

/// Either pieces, or one object without its crumbs.
struct ObjectPieces {
  std::unique_ptr<Split> parts;                       ///< two pieces or more
  std::vector<std::shared_ptr<PieceOrigin>> origins;  ///< of the pieces, in their order
  std::vector<BrickEdit> without_crumbs;              ///< one piece: the edits that remove its crumbs
  std::size_t crumbs = 0;
  SolidMeasure crumb_measure;
};

/// @param whole  with its shells repaired. Another thread may step it meanwhile if it is frozen.
/// @param finder  up to date with it.
/// @param first_id  of the pieces: State::next_id.
/// @param pool  used up as far as the pieces need it; null: allocates now.
/// Null: the object is whole without crumbs, or in more pieces than `most`. The same object gives the same pieces, bit
/// for bit. Parallel inside if wanted. @cost a mandible of 130 000 bricks at 0.1 mm: 22 to 29 ms of two cores beside a
/// haptic thread, with a pool.
std::unique_ptr<ObjectPieces> makePieces(const CutObject& whole, PieceFinder& finder, std::uint32_t first_id,
                                         std::size_t most, PiecePool* pool = nullptr, bool is_parallel = true);

}  // namespace kerf
