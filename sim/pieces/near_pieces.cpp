#include "sim/pieces/near_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf::internal {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

}  // namespace

void NearPieces::find(const SplitView& view, const Vec3i& brick) {
  const OverlayField& field = view.pieces.field();
  voxel_ = static_cast<float>(field.voxel());
  background_ = field.background();
  const BrickValues* const values = field.valuesAt(brick);
  if (values)
    values_ = *values;
  else
    values_.fill(field.constantAt(brick));
  view.pieces.piecesIn(brick, piece_of_);

  // Collects balls around the outermost nodes within reach, piece by piece.
  count_ = 0;
  view.forEachWithinReach(brick, [&](std::uint32_t slot, const Vec3i& step, const Vec3i& low, const Vec3i& high) {
    const Vec3i shift = step * kBrickSide;
    const BrickValues* phi = nullptr;
    bool is_known = false;
    NearPiece* last = nullptr;
    view.pieces.forEachOutermost(slot, low, high, [&](std::uint32_t id, int n) {
      const int i = shift[0] + (n >> 6), j = shift[1] + (n >> 3 & 7), k = shift[2] + (n & 7);
      if (!last || last->id != id) last = &addPiece(id);
      markAround(*last, i, j, k);
      if (!is_known) {
        is_known = true;
        phi = field.valuesAt(brick + step);
      }
      last->balls.push_back({i, j, k, phi ? (*phi)[static_cast<std::size_t>(n)] : field.interior()});
      return false;
    });
  });

  for (NearPiece& piece : used()) nearBalls(piece.balls, view.steps, piece.distance);
}

void NearPieces::valuesOf(std::uint32_t id, BrickValues& out) const {
  const NearPiece* const own = pieceOf(id);
  BrickValues to_others;
  distanceToOthers(id, to_others);

  out = values_;
  for (std::size_t n = 0; n < kBrickNodes; ++n) {
    if (piece_of_[n] == id) continue;
    const bool is_outside = piece_of_[n] == PieceFinder::kNoPiece;
    if (is_outside && ((own && own->is_next[n]) || to_others[n] == kFar)) continue;
    // Nearer to this piece: the value stays, unless it must belong to another piece (balls miss sharp corners).
    const float to_own = own ? own->distance[n] : kFar;
    const float distance_to_own = is_outside && to_own <= to_others[n] ? to_own - 0.5f * voxel_ : to_own;
    out[n] = std::min(background_, std::max(std::abs(out[n]), distance_to_own));
  }
}

// Distance of each node to the nearest piece except `id`.
void NearPieces::distanceToOthers(std::uint32_t id, BrickValues& out) const {
  out.fill(kFar);
  for (const NearPiece& piece : used())
    if (piece.id != id)
      for (std::size_t n = 0; n < out.size(); ++n) out[n] = std::min(out[n], piece.distance[n]);
}

// Null: the piece is not near.
const NearPieces::NearPiece* NearPieces::pieceOf(std::uint32_t id) const {
  for (const NearPiece& piece : used())
    if (piece.id == id) return &piece;
  return nullptr;
}

// The existing entry, or a new one.
NearPieces::NearPiece& NearPieces::addPiece(std::uint32_t id) {
  for (NearPiece& piece : used())
    if (piece.id == id) return piece;
  if (count_ == pieces_.size()) pieces_.emplace_back();
  NearPiece& piece = pieces_[count_++];
  piece.id = id;
  piece.distance.fill(kFar);
  piece.is_next.fill(0);
  piece.balls.clear();
  return piece;
}

// Marks the six nodes next to an inside node, within the brick.
void NearPieces::markAround(NearPiece& piece, int i, int j, int k) {
  if (std::min({i, j, k}) < -1 || std::max({i, j, k}) > kBrickSide) return;
  const auto mark = [&](int x, int y, int z) {
    if (((x | y | z) & ~(kBrickSide - 1)) == 0) piece.is_next[static_cast<std::size_t>(nodeOffset(x, y, z))] = 1;
  };
  mark(i - 1, j, k);
  mark(i + 1, j, k);
  mark(i, j - 1, k);
  mark(i, j + 1, k);
  mark(i, j, k - 1);
  mark(i, j, k + 1);
}

}  // namespace kerf::internal
