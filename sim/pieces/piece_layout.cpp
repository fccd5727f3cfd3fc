#include "sim/pieces/piece_layout.h"

#include <algorithm>
#include <span>
#include <utility>

#include "sim/object/for_each.h"

namespace kerf::internal {
namespace {

// Assigns some bricks, one after the other, to pieces.
class Layout {
 public:
  // @param out  of the pieces first, first + 1, ...
  Layout(const SplitView& view, std::uint32_t first, std::span<LotBricks> out)
      : view_(view), first_(first), out_(out) {}

  void add(std::uint32_t slot) {
    const std::uint32_t id = view_.in_sight[view_.pieces.blockOfSlot(slot)];
    if (id == PieceFinder::kSeveralPieces)
      addAmongSeveral(slot);
    else if (isWanted(id))
      addAlone(slot, id);
  }

 private:
  struct Around {
    std::uint32_t slot;
    Vec3i shift;  // of its nodes
  };

  bool isWanted(std::uint32_t id) const { return id >= first_ && id - first_ < out_.size(); }

  // A brick with only one piece in sight: the usual case.
  void addAlone(std::uint32_t slot, std::uint32_t id) {
    LotBricks& to = out_[id - first_];
    if (view_.is_stored[slot]) {
      to.bricks.push_back(view_.pieces.brickOfSlot(slot));
      if (view_.piece_of[slot] != id) to.at_edge.push_back(to.bricks.back());
    } else if (view_.piece_of[slot] == id) {
      to.interior.push_back(view_.pieces.brickOfSlot(slot));
    }
  }

  // Gives a brick to the pieces with inside nodes in it or around it. A constant without any piece is air.
  void addAmongSeveral(std::uint32_t slot) {
    const bool is_stored = view_.is_stored[slot] != 0;
    const std::uint32_t its = view_.piece_of[slot];
    if (!is_stored && its == PieceFinder::kNoPiece) return;

    const Vec3i brick = view_.pieces.brickOfSlot(slot);
    if (const std::uint32_t near = view_.onlyPieceAround(brick); near != PieceFinder::kSeveralPieces)
      near_.assign(near == PieceFinder::kNoPiece ? 0 : 1, near);
    else
      findAround(brick);

    for (const std::uint32_t near : near_) {
      if (!isWanted(near)) continue;
      LotBricks& to = out_[near - first_];
      if (!is_stored && its == near) {
        to.interior.push_back(brick);
        continue;
      }
      to.bricks.push_back(brick);
      if (its != near) to.at_edge.push_back(brick);
      if (near_.size() > 1 && hasOthersWithinReach(near)) to.changed.push_back(brick);
    }
  }

  // Finds the bricks around with inside nodes, and their pieces.
  void findAround(const Vec3i& brick) {
    around_.clear();
    near_.clear();
    const auto add = [&](std::uint32_t piece) {
      if (std::find(near_.begin(), near_.end(), piece) == near_.end()) near_.push_back(piece);
    };
    view_.forEachAround(brick, [&](std::uint32_t slot, const Vec3i& step) {
      around_.push_back({slot, step * kBrickSide});
      if (view_.piece_of[slot] != PieceFinder::kSeveralPieces)
        add(view_.piece_of[slot]);
      else
        view_.pieces.forEachPart(slot, [&](std::uint32_t piece, const Vec3i&, const Vec3i&) { add(piece); });
    });
  }

  // Whether there may be inside nodes of another piece, along each axis. @pre findAround() was called for the brick.
  bool hasOthersWithinReach(std::uint32_t id) const {
    const int reach = view_.steps.reach();
    const Vec3i low = Vec3i::Constant(-reach), high = Vec3i::Constant(kBrickSide - 1 + reach);
    return std::any_of(around_.begin(), around_.end(), [&](const Around& at) {
      bool out = false;
      if (view_.piece_of[at.slot] != id)
        view_.pieces.forEachPart(at.slot, [&](std::uint32_t piece, const Vec3i& part_low, const Vec3i& part_high) {
          out |= piece != id && ((part_low + at.shift).array() <= high.array()).all() &&
                 ((part_high + at.shift).array() >= low.array()).all();
        });
      return out;
    });
  }

  const SplitView& view_;
  std::uint32_t first_;
  std::span<LotBricks> out_;
  std::vector<Around> around_;
  std::vector<std::uint32_t> near_;  // pieces
};

// Joins the lots of one piece.
class LotsOfPiece {
 public:
  // @param has_added  slots added after the finder began come last, in any order of coordinates.
  LotsOfPiece(const std::vector<LotBricks>& lots, std::size_t lot_count, std::size_t pieces, std::size_t piece,
              bool has_added)
      : lots_(lots), lot_count_(lot_count), pieces_(pieces), piece_(piece), has_added_(has_added) {}

  void join(std::vector<Vec3i> LotBricks::*list, std::vector<Vec3i>& to) const {
    std::size_t size = 0;
    for (std::size_t lot = 0; lot < lot_count_; ++lot) size += (lots_[lot * pieces_ + piece_].*list).size();
    to.reserve(size);
    for (std::size_t lot = 0; lot < lot_count_; ++lot) {
      const std::vector<Vec3i>& from = lots_[lot * pieces_ + piece_].*list;
      to.insert(to.end(), from.begin(), from.end());
    }
    if (!has_added_) return;

    const auto isBefore = [](const Vec3i& a, const Vec3i& b) { return coordKey(a) < coordKey(b); };
    const auto added = std::is_sorted_until(to.begin(), to.end(), isBefore);
    std::sort(added, to.end(), isBefore);
    std::inplace_merge(to.begin(), added, to.end(), isBefore);
  }

 private:
  const std::vector<LotBricks>& lots_;
  std::size_t lot_count_, pieces_, piece_;
  bool has_added_;
};

}  // namespace

std::vector<PieceBricks> layOutPieces(const SplitView& view, std::uint32_t first, std::size_t count, bool is_parallel,
                                      SplitLists& lists) {
  // Lot by lot.
  const std::uint32_t slots = view.pieces.slotCount(), lot_count = (slots + kSlotsALot - 1) / kSlotsALot;
  std::vector<LotBricks>& lots = lists.lots;
  if (lots.size() < lot_count * count) lots.resize(lot_count * count);
  forEach(lot_count, is_parallel, [&](std::size_t lot) {
    const std::span<LotBricks> to = std::span(lots).subspan(lot * count, count);
    for (LotBricks& piece : to) piece.clear();
    Layout layout(view, first, to);
    const auto begin = static_cast<std::uint32_t>(lot) * kSlotsALot;
    for (std::uint32_t s = begin; s < std::min(slots, begin + kSlotsALot); ++s) layout.add(s);
  });

  // Piece by piece.
  std::vector<PieceBricks> out(count);
  for (std::size_t n = 0; n < std::min(count, lists.out.size()); ++n) out[n] = std::move(lists.out[n]);
  forEach(count, is_parallel, [&](std::size_t n) {
    const LotsOfPiece of_piece(lots, lot_count, count, n, view.pieces.hasAdded());
    of_piece.join(&LotBricks::bricks, out[n].bricks);
    of_piece.join(&LotBricks::interior, out[n].interior);
    of_piece.join(&LotBricks::at_edge, out[n].at_edge);
    std::vector<Vec3i> changed;
    of_piece.join(&LotBricks::changed, changed);
    out[n].changed.resize(changed.size());
    for (std::size_t e = 0; e < changed.size(); ++e) out[n].changed[e].brick = changed[e];
  });
  return out;
}

}  // namespace kerf::internal
