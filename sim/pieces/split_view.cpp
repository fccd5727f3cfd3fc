#include "sim/pieces/split_view.h"

#include <cmath>

#include "sim/object/for_each.h"

namespace kerf::internal {
namespace {

// Per slot, whether it has values, not a constant.
void findStored(const PieceFinder& pieces, std::vector<unsigned char>& out) {
  const OverlayField& field = pieces.field();
  out.resize(pieces.slotCount());
  for (std::uint32_t s = 0; s < pieces.slotCount(); ++s) out[s] = pieces.isBaked(s);
  // Undone edits count as never made: the result depends on the values, not on their history.
  for (std::size_t b = 0; b < field.changed().brickCount(); ++b) {
    const Vec3i& c = field.changed().brickCoord(b);
    const auto s = static_cast<std::uint32_t>(pieces.slotOf(c));
    if (out[s]) continue;
    const float constant = pieces.wasAir(s) ? field.background() : field.constantAt(c);
    const BrickValues& values = field.changed().brick(b);
    out[s] = std::any_of(values.begin(), values.end(), [&](float v) { return v != constant; });
  }
}

}  // namespace

SplitView::SplitView(const PieceFinder& finder, bool is_parallel, SplitLists& lists)
    : pieces(finder), piece_of(lists.piece_of), is_stored(lists.is_stored) {
  forEach(3, is_parallel, [&](std::size_t n) {
    if (n == 0) finder.piecesOfSlots(lists.piece_of);
    if (n == 1) in_sight = finder.piecesInSight();
    if (n == 2) findStored(finder, lists.is_stored);
  });
  // Reach: the band plus a ball's radius of at most a voxel, limited to the bricks around.
  const OverlayField& field = finder.field();
  const int reach = static_cast<int>(std::ceil(double{field.background()} / field.voxel()));
  steps = NodeSteps(std::clamp(reach, 1, kBrickSide - 1), static_cast<float>(field.voxel()));
}

std::uint32_t SplitView::onlyPieceAround(const Vec3i& brick) const {
  std::uint32_t out = PieceFinder::kNoPiece;
  pieces.forEachAround(brick, [&](std::uint32_t slot, const Vec3i&) {
    const std::uint32_t its = piece_of[slot];
    if (its != PieceFinder::kNoPiece && its != out)
      out = out == PieceFinder::kNoPiece ? its : PieceFinder::kSeveralPieces;
  });
  return out;
}

bool SplitView::isWithinReach(const Vec3i& brick, std::uint32_t id) const {
  const std::int32_t own = pieces.slotOf(brick);
  if (own >= 0 && piece_of[static_cast<std::size_t>(own)] == id) return true;
  bool out = false;
  forEachWithinReach(brick, [&](std::uint32_t slot, const Vec3i&, const Vec3i& low, const Vec3i& high) {
    if (out || (piece_of[slot] != id && piece_of[slot] != PieceFinder::kSeveralPieces)) return;
    out = pieces.forEachOutermost(slot, low, high, [&](std::uint32_t piece, int) { return piece == id; });
  });
  return out;
}

}  // namespace kerf::internal
