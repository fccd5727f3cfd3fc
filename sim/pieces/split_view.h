// Data shared by all pieces of a split: the piece of each brick, and the pieces near it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sim/pieces/near_balls.h"
#include "sim/pieces/pieces.h"
#include "sim/pieces/split_lists.h"

namespace kerf::internal {

/// Names bricks by their slots in the finder; -1 is air. Made once per split; then any number of threads read it.
struct SplitView {
  /// @param finder  after find(). @param lists  keeps the results for every slot. Parallel inside if wanted.
  SplitView(const PieceFinder& finder, bool is_parallel, SplitLists& lists);

  /// Calls visit(slot, step) for a brick and those around it that have inside nodes.
  template <class Visit>
  void forEachAround(const Vec3i& brick, const Visit& visit) const {
    pieces.forEachAround(brick, [&](std::uint32_t slot, const Vec3i& step) {
      if (piece_of[slot] != PieceFinder::kNoPiece) visit(slot, step);
    });
  }
  /// As forEachAround(), with the box of each brick's nodes within reach, counted in their own brick: visit(slot, step,
  /// low, high).
  template <class Visit>
  void forEachWithinReach(const Vec3i& brick, const Visit& visit) const {
    constexpr int kLast = kBrickSide - 1;
    forEachAround(brick, [&](std::uint32_t slot, const Vec3i& step) {
      const Vec3i shift = step * kBrickSide;
      visit(slot, step, (Vec3i::Constant(-steps.reach()) - shift).cwiseMax(0),
            (Vec3i::Constant(kLast + steps.reach()) - shift).cwiseMin(kLast));
    });
  }

  /// The piece of all inside nodes in a brick and those around it; or kSeveralPieces, or kNoPiece.
  std::uint32_t onlyPieceAround(const Vec3i& brick) const;
  /// Whether the piece has inside nodes in the brick, or an outermost node within reach of it.
  bool isWithinReach(const Vec3i& brick, std::uint32_t id) const;

  const PieceFinder& pieces;
  const std::vector<std::uint32_t>& piece_of;   ///< per slot: as PieceFinder::pieceOfBrick()
  std::vector<std::uint32_t> in_sight;          ///< per block: PieceFinder::piecesInSight()
  const std::vector<unsigned char>& is_stored;  ///< per slot: whether it has values, not a constant
  NodeSteps steps{1, 1};                        ///< reach of the changes near another piece
};

}  // namespace kerf::internal
