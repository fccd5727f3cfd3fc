#include "sim/pieces/split_pool.h"

#include <algorithm>
#include <span>
#include <utility>

#include "sim/object/huge_pages.h"
#include "sim/pieces/cut_size.h"
#include "sim/pieces/split_lists.h"

namespace kerf {

using internal::reserveTouched;

SplitPool::SplitPool() : lists_(std::make_unique<internal::SplitLists>()) {}
SplitPool::~SplitPool() = default;
SplitPool::SplitPool(SplitPool&&) noexcept = default;
SplitPool& SplitPool::operator=(SplitPool&&) noexcept = default;

void SplitPool::reserve(const PieceFinder& finder, std::size_t pieces) {
  const std::size_t slots = finder.slotCount(), edited = finder.field().changed().brickCount();
  // At most as many bricks are near another piece as were edited. Reserves more than needed now, once for a whole cut:
  // no reallocation while a cut goes through.
  const std::size_t changed = edited + 512, more_changed = std::max(2 * changed, internal::bricksOfACut(slots));
  const std::size_t added = slots + 512, more = slots + slots / 16 + 4096;

  internal::SplitLists& to = *lists_;
  reserveTouched(to.piece_of, added, more);
  reserveTouched(to.is_stored, added, more);
  reserveTouched(to.wanted, pieces * changed, pieces * more_changed);
  reserveTouched(to.begin, pieces * changed, pieces * more_changed);

  constexpr std::size_t kLot = internal::kSlotsALot;
  to.lots.resize(pieces * ((slots + kLot - 1) / kLot));
  for (internal::LotBricks& lot : to.lots) {
    for (auto* list : {&lot.bricks, &lot.interior}) reserveTouched(*list, kLot, kLot);
    for (auto* list : {&lot.changed, &lot.at_edge}) reserveTouched(*list, kLot / 8, kLot / 8);
  }

  to.out.resize(std::max(to.out.size(), pieces));
  for (PieceBricks& piece : std::span(to.out).first(pieces)) {
    for (auto* list : {&piece.bricks, &piece.interior}) reserveTouched(*list, added, more);
    reserveTouched(piece.at_edge, changed, more_changed);
    reserveTouched(piece.changed, changed, more_changed);
  }
}

void SplitPool::takeBack(PieceBricks&& bricks) {
  const auto isWithoutMemory = [](const PieceBricks& piece) { return piece.bricks.capacity() == 0; };
  const auto piece = std::find_if(lists_->out.begin(), lists_->out.end(), isWithoutMemory);
  if (piece == lists_->out.end()) return;
  *piece = std::move(bricks);
  piece->bricks.clear();
  piece->interior.clear();
  piece->changed.clear();
  piece->at_edge.clear();
}

}  // namespace kerf
