// What is common to the pieces that are split from an object at a time: whose each brick is, and who is near it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sim/pieces/near_balls.h"
#include "sim/pieces/pieces.h"
#include "sim/pieces/split_lists.h"

namespace kerf::internal {

/// Bricks go by their slots in the finder; -1 is air. Made once per split; then any number of threads read it.
struct SplitView {
  /// @param finder  after find(). @param lists  keeps what is computed for every slot. Parallel inside if wanted.
  SplitView(const PieceFinder& finder, bool is_parallel, SplitLists& lists);

  /// Calls visit(slot, step) for the bricks around one, and itself, that hold something inside.
  template <class Visit>
  void forEachAround(const Vec3i& brick, const Visit& visit) const {
    pieces.forEachAround(brick, [&](std::uint32_t slot, const Vec3i& step) {
      if (piece_of[slot] != PieceFinder::kNoPiece) visit(slot, step);
    });
  }
  /// As forEachAround(), with the box of the nodes of each that are within reach of the brick, counted in their own:
  /// visit(slot, step, low, high).
  template <class Visit>
  void forEachWithinReach(const Vec3i& brick, const Visit& visit) const {
    constexpr int kLast = kBrickSide - 1;
    forEachAround(brick, [&](std::uint32_t slot, const Vec3i& step) {
      const Vec3i shift = step * kBrickSide;
      visit(slot, step, (Vec3i::Constant(-steps.reach()) - shift).cwiseMax(0),
            (Vec3i::Constant(kLast + steps.reach()) - shift).cwiseMin(kLast));
    });
  }

  /// The piece of all that is inside in the bricks around one, and itself; or kSeveralPieces, or kNoPiece.
  std::uint32_t onlyPieceAround(const Vec3i& brick) const;
  /// Whether the brick is in a piece, or an outermost node of it is within reach.
  bool isWithinReach(const Vec3i& brick, std::uint32_t id) const;

  const PieceFinder& pieces;
  const std::vector<std::uint32_t>& piece_of;   ///< per slot: as PieceFinder::pieceOfBrick()
  std::vector<std::uint32_t> in_sight;          ///< per block: PieceFinder::piecesInSight()
  const std::vector<unsigned char>& is_stored;  ///< per slot: whether it has values, not a constant
  NodeSteps steps{1, 1};                        ///< as far as values near another piece change
};

}  // namespace kerf::internal
