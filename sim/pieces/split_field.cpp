#include "sim/pieces/split_field.h"

#include <algorithm>
#include <utility>

#include "sim/object/for_each.h"
#include "sim/pieces/near_pieces.h"
#include "sim/pieces/piece_layout.h"
#include "sim/pieces/split_lists.h"
#include "sim/pieces/split_view.h"

namespace kerf {
namespace {

using internal::SplitLists;
using internal::SplitView;
using internal::WantedBrick;

// Computes the wanted values brick by brick, so that one search serves all pieces near a brick.
void sortWanted(const std::vector<PieceBricks>& pieces, SplitLists& lists) {
  std::vector<WantedBrick>& wanted = lists.wanted;
  wanted.clear();
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (std::size_t e = 0; e < pieces[p].changed.size(); ++e)
      wanted.push_back({coordKey(pieces[p].changed[e].brick), p, e});
  std::sort(wanted.begin(), wanted.end(), [](const WantedBrick& a, const WantedBrick& b) {
    return a.brick != b.brick ? a.brick < b.brick : a.piece < b.piece;
  });

  lists.begin.clear();
  for (std::size_t n = 0; n < wanted.size(); ++n)
    if (n == 0 || wanted[n].brick != wanted[n - 1].brick) lists.begin.push_back(n);
  lists.begin.push_back(wanted.size());
}

// Values of the bricks near other pieces. @param first  id of the first piece.
void fillChanged(const SplitView& view, std::uint32_t first, bool is_parallel, const SplitLists& lists,
                 std::vector<PieceBricks>& out) {
  constexpr std::size_t kBricksALot = 16;
  const std::size_t bricks = lists.begin.size() - 1;
  internal::forEach((bricks + kBricksALot - 1) / kBricksALot, is_parallel, [&](std::size_t lot) {
    internal::NearPieces near;
    for (std::size_t b = lot * kBricksALot; b < std::min(bricks, (lot + 1) * kBricksALot); ++b) {
      bool is_found = false;
      for (std::size_t n = lists.begin[b]; n < lists.begin[b + 1]; ++n) {
        const WantedBrick& wanted = lists.wanted[n];
        const std::uint32_t id = first + static_cast<std::uint32_t>(wanted.piece);
        BrickEdit& edit = out[wanted.piece].changed[wanted.edit];
        if (!view.isWithinReach(edit.brick,
                                id)) {  // usual case: another piece's alone
          edit.phi.fill(view.pieces.field().background());
          continue;
        }
        if (!is_found) near.find(view, edit.brick);
        is_found = true;
        near.valuesOf(id, edit.phi);
      }
    }
  });
}

std::vector<PieceBricks> splitBricksOf(const PieceFinder& pieces, std::uint32_t first, std::size_t count,
                                       bool is_parallel, SplitLists& lists) {
  const SplitView view(pieces, is_parallel, lists);
  std::vector<PieceBricks> out = internal::layOutPieces(view, first, count, is_parallel, lists);
  sortWanted(out, lists);
  fillChanged(view, first, is_parallel, lists, out);
  return out;
}

}  // namespace

std::vector<PieceBricks> bricksOfPieces(const PieceFinder& pieces, std::size_t count, bool is_parallel,
                                        SplitPool* pool) {
  SplitPool fresh;
  return splitBricksOf(pieces, 0, count, is_parallel, (pool ? *pool : fresh).lists());
}

BrickField splitField(const PieceFinder& pieces, std::uint32_t id) {
  const OverlayField& field = pieces.field();
  SplitLists lists;
  const PieceBricks piece = std::move(splitBricksOf(pieces, id, 1, true, lists).front());
  BrickField out(field.voxel(), field.background(), field.interior());
  for (const Vec3i& c : piece.interior) out.markInterior(c);
  out.reserve(piece.bricks.size());
  std::size_t next = 0;
  for (const Vec3i& c : piece.bricks) {
    const bool is_changed = next < piece.changed.size() && piece.changed[next].brick == c;
    out.add(c, is_changed ? piece.changed[next++].phi : *field.valuesAt(c));
  }
  return out;
}

}  // namespace kerf
