// Distances of the nodes of one brick to the pieces near it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/pieces/near_balls.h"
#include "sim/pieces/split_view.h"

namespace kerf::internal {

/// One brick of the whole, and the pieces near it. Call find() for one brick after the other, then valuesOf() for each
/// piece that has the brick. Keeps its memory from brick to brick.
class NearPieces {
 public:
  /// Estimates distances by the union of balls of radius |phi| about a piece's outermost nodes: |p - a| + phi(a).
  /// @cost 10 us.
  void find(const SplitView& view, const Vec3i& brick);

  /// The brick's values in one piece alone: see splitField(). @pre find() was called for the brick.
  void valuesOf(std::uint32_t id, BrickValues& out) const;

 private:
  struct NearPiece {
    std::uint32_t id;
    std::vector<NodeBall> balls;
    BrickValues distance;                            // of each node to the piece, mm; infinite beyond reach
    std::array<unsigned char, kBrickNodes> is_next;  // whether the node is next to an inside node of the piece
  };

  std::span<NearPiece> used() { return std::span(pieces_).first(count_); }
  std::span<const NearPiece> used() const { return std::span(pieces_).first(count_); }
  const NearPiece* pieceOf(std::uint32_t id) const;
  NearPiece& addPiece(std::uint32_t id);
  void distanceToOthers(std::uint32_t id, BrickValues& out) const;
  static void markAround(NearPiece& piece, int i, int j, int k);

  float voxel_ = 0, background_ = 0;                 // of the field, mm
  BrickValues values_;                               // of the whole
  std::array<std::uint32_t, kBrickNodes> piece_of_;  // of each node
  std::vector<NearPiece> pieces_;                    // the first count_ are in use
  std::size_t count_ = 0;
};

}  // namespace kerf::internal
