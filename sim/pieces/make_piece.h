// One piece of an object as an object of its own.
#pragma once

#include <memory>

#include "sim/object/cut_object.h"

namespace kerf {

/// Prepares memory for a piece: it refers to the loaded bricks and has none of its own; `bricks` of them can change.
/// Writes to every page, because new memory is slow to come and a piece should not wait for it.
CutObject blankPiece(std::shared_ptr<const BakedObject> baked, std::size_t bricks);

/// One piece of an object as an object of its own, with its pose. It shares the uncut bricks with the whole. Its ledger
/// starts anew. Allocates. Another thread may step the whole meanwhile, if it is frozen: CutObject::isFrozen().
/// @param bricks  from bricksOfPieces(), with the finder up to date with `whole`. Faster if its shells are repaired.
/// @param blank  of the same baked object, used up; null: makes one. @param is_parallel  uses all cores.
CutObject makePiece(const CutObject& whole, const PieceBricks& bricks, std::unique_ptr<CutObject> blank = nullptr,
                    bool is_parallel = false);

}  // namespace kerf
