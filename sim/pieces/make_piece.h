// One piece of an object as an object of its own.
#pragma once

#include <memory>

#include "sim/object/cut_object.h"

namespace kerf {

/// What a piece is made from, beforehand: it knows the bricks as they were loaded, and has none of them; `bricks` of
/// them can change. Every page is written to: new memory is slow to come, and a piece should not wait for it.
CutObject blankPiece(std::shared_ptr<const BakedObject> baked, std::size_t bricks);

/// One piece of an object as an object of its own, with its pose. What was not cut is shared with the whole. Its ledger
/// starts anew. Allocates. Another thread may step the whole meanwhile, if it is frozen: CutObject::isFrozen().
/// @param bricks  of bricksOfPieces(), the finder being up to date with `whole`. Quicker if its shells are repaired.
/// @param blank  of the same baked object, to be used up; null: one is made. @param is_parallel  by all cores.
CutObject makePiece(const CutObject& whole, const PieceBricks& bricks, std::unique_ptr<CutObject> blank = nullptr,
                    bool is_parallel = false);

}  // namespace kerf
