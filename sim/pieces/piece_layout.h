// Assigns bricks to pieces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/object/piece_bricks.h"
#include "sim/pieces/split_lists.h"
#include "sim/pieces/split_view.h"

namespace kerf::internal {

/// The bricks of the pieces first, first + 1, ... in order of their coordinates. The bricks in `changed`, which are
/// near other pieces, have no values yet. O(all bricks); parallel inside if wanted.
std::vector<PieceBricks> layOutPieces(const SplitView& view, std::uint32_t first, std::size_t count, bool is_parallel,
                                      SplitLists& lists);

}  // namespace kerf::internal
