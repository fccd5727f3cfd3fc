// Look-up: PieceFinder's answers about nodes, bricks and blocks after find().
#include <algorithm>
#include <cassert>
#include <limits>

#include "sim/pieces/pieces.h"

namespace kerf {
namespace {

// Combines the pieces of two neighbours.
constexpr std::uint32_t both(std::uint32_t a, std::uint32_t b) {
  if (a == PieceFinder::kNoPiece || a == b) return b;
  return b == PieceFinder::kNoPiece ? a : PieceFinder::kSeveralPieces;
}

}  // namespace

// @pre the node is inside.
std::uint32_t PieceFinder::partAt(std::int32_t slot, int offset) const {
  const std::int32_t index = parts_of_[indexOf(slot)];
  if (index < 0) return 0;
  return static_cast<std::uint32_t>(parts_[indexOf(index)].partAt(static_cast<std::size_t>(offset)));
}

std::uint32_t PieceFinder::groupOf(std::int32_t slot, std::uint32_t part) const {
  const std::int32_t index = parts_of_[indexOf(slot)];
  return index < 0 ? group_of_full_[indexOf(slot)] : parts_[indexOf(index)].parts[part].group;
}

std::uint32_t PieceFinder::pieceAt(const Vec3i& node) const {
  assert(is_current_);
  const std::int32_t slot = slotOf(brickOf(node));
  if (slot == kNoSlot || partCount(slot) == 0) return kNoPiece;
  const int offset = nodeOffset(node[0], node[1], node[2]);
  const std::int32_t index = parts_of_[indexOf(slot)];
  if (index >= 0 && !parts_[indexOf(index)].isInside(static_cast<std::size_t>(offset))) return kNoPiece;
  return piecesOfBlock(indexOf(slot))[groupOf(slot, partAt(slot, offset))];
}

void PieceFinder::piecesIn(const Vec3i& brick, std::span<std::uint32_t, kBrickNodes> out) const {
  assert(is_current_);
  const std::int32_t slot = slotOf(brick);
  if (slot == kNoSlot || partCount(slot) == 0) return std::fill(out.begin(), out.end(), kNoPiece);
  const std::uint32_t* const piece = piecesOfBlock(indexOf(slot));
  const std::int32_t index = parts_of_[indexOf(slot)];
  if (index < 0) return std::fill(out.begin(), out.end(), piece[groupOf(slot, 0)]);

  const internal::BrickParts& parts = parts_[indexOf(index)];
  for (std::size_t n = 0; n < out.size(); ++n)
    out[n] = parts.isInside(n) ? piece[parts.parts[parts.partAt(n)].group] : kNoPiece;
}

std::uint32_t PieceFinder::pieceOfSlot(std::size_t s) const {
  std::uint32_t piece = kNoPiece;
  const std::uint32_t* const of = piecesOfBlock(s);
  const auto slot = static_cast<std::int32_t>(s);
  const std::uint32_t parts = partCount(slot);
  for (std::uint32_t p = 0; p < parts; ++p) {
    const std::uint32_t its = of[groupOf(slot, p)];
    if (piece != kNoPiece && piece != its) return kSeveralPieces;
    piece = its;
  }
  return piece;
}

std::uint32_t PieceFinder::pieceOfBrick(const Vec3i& brick) const {
  assert(is_current_);
  const std::int32_t slot = slotOf(brick);
  return slot == kNoSlot ? kNoPiece : pieceOfSlot(indexOf(slot));
}

void PieceFinder::piecesOfSlots(std::vector<std::uint32_t>& out) const {
  assert(is_current_);
  out.assign(keys_.size(), kNoPiece);
  for (const Block& block : blocks_) {
    const bool is_one = block.groups.size() == 1;
    for (const std::int32_t slot : block.slots) {
      const std::size_t s = indexOf(slot);
      if (partCount(slot) > 0) out[s] = is_one ? piece_of_group_[block.first_group] : pieceOfSlot(s);
    }
  }
}

std::vector<std::uint32_t> PieceFinder::piecesInSight() const {
  assert(is_current_);
  if (blocks_.empty()) return {};

  // A grid of all blocks, with a margin of empty cells.
  std::vector<Vec3i> at;
  Vec3i low = Vec3i::Constant(std::numeric_limits<int>::max()), high = -low;
  for (const Block& block : blocks_) {
    at.push_back(brickOf(internal::coordOf(keys_[indexOf(block.slots.front())])));
    low = low.cwiseMin(at.back());
    high = high.cwiseMax(at.back());
  }
  const Vec3i size = high - low + Vec3i::Constant(3);
  const auto cellOf = [&](const Vec3i& block) {
    const Vec3i from_low = block - low + Vec3i::Ones();
    return static_cast<std::size_t>((from_low[0] * size[1] + from_low[1]) * size[2] + from_low[2]);
  };

  // Own piece of each block.
  std::vector<std::uint32_t> cells(static_cast<std::size_t>(size.cast<std::ptrdiff_t>().prod()), kNoPiece);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    std::uint32_t& cell = cells[cellOf(at[b])];
    for (std::uint32_t g = 0; g < blocks_[b].groups.size(); ++g)
      cell = both(cell, piece_of_group_[blocks_[b].first_group + g]);
  }

  // Combines neighbours axis by axis. The outermost cells belong to no block: the cell before the first of a row is
  // empty.
  std::vector<std::uint32_t> from;
  const auto row = static_cast<std::size_t>(size[2]), plane = row * static_cast<std::size_t>(size[1]);
  for (const std::size_t step : {std::size_t{1}, row, plane}) {
    from = cells;
    for (std::size_t n = step; n + step < cells.size(); ++n)
      cells[n] = both(cells[n], both(from[n - step], from[n + step]));
  }

  std::vector<std::uint32_t> out(blocks_.size());
  for (std::size_t b = 0; b < out.size(); ++b) out[b] = cells[cellOf(at[b])];
  return out;
}

}  // namespace kerf
