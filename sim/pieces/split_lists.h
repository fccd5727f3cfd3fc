// Lists for splitting an object, kept by SplitPool.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/object/piece_bricks.h"

namespace kerf::internal {

/// Slots of the finder that one thread lays out at a time.
inline constexpr std::uint32_t kSlotsALot = 4096;

/// Bricks of a piece in one lot: as PieceBricks, without values.
struct LotBricks {
  std::vector<Vec3i> bricks, interior, changed, at_edge;
  void clear() {
    bricks.clear();
    interior.clear();
    changed.clear();
    at_edge.clear();
  }
};

/// A brick of PieceBricks::changed that needs its values.
struct WantedBrick {
  std::uint64_t brick;  ///< key
  std::size_t piece, edit;
};

struct SplitLists {
  std::vector<std::uint32_t> piece_of;   ///< per slot: see SplitView
  std::vector<unsigned char> is_stored;  ///< per slot: see SplitView
  std::vector<LotBricks> lots;           ///< for each lot and each piece
  std::vector<WantedBrick> wanted;       ///< in order of their bricks
  std::vector<std::size_t> begin;        ///< starts of the bricks in `wanted`
  std::vector<PieceBricks> out;          ///< empty lists for the result
};

}  // namespace kerf::internal
