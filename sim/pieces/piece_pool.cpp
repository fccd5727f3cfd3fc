#include "sim/pieces/piece_pool.h"

#include <algorithm>
#include <new>
#include <utility>

#include "sim/object/huge_pages.h"
#include "sim/pieces/cut_size.h"
#include "sim/pieces/make_piece.h"

namespace kerf {

void PiecePool::reserve(const std::shared_ptr<const BakedObject>& baked, const PieceFinder& finder,
                        std::size_t bricks) {
  constexpr std::size_t kPieces = 2;
  blanks.resize(kPieces);
  cuts.resize(kPieces);

  // Own bricks, beside those that stay free: the edited bricks, and among them those near the other piece. Reserves
  // more than needed now, once for a whole cut.
  const std::size_t edited = finder.field().changed().brickCount();
  const std::size_t a_cut = internal::bricksOfACut(baked->slots().size());
  const std::size_t wanted = bricks + edited + 1024, more = wanted + std::max<std::size_t>(a_cut, 512);
  for (std::unique_ptr<CutObject>& blank : blanks) {
    if (!blank) blank = std::make_unique<CutObject>(blankPiece(baked, more));
    if (blank->freeBricks() < wanted && !blank->reserve(more - blank->freeBricks())) throw std::bad_alloc();
  }

  for (std::vector<BrickEdit>& cut : cuts)
    internal::reserveTouched(cut, edited + 256, std::max(2 * edited + 1024, a_cut));
  lists.reserve(finder, kPieces);
}

std::shared_ptr<const PieceOrigin> PiecePool::takeBack(PieceOrigin& origin) {
  auto out = std::make_shared<const PieceOrigin>(origin);
  lists.takeBack({std::move(origin.bricks), std::move(origin.interior), std::move(origin.near_others), {}});

  const auto isWithoutMemory = [](const std::vector<BrickEdit>& cut) { return cut.capacity() == 0; };
  const auto cut = std::find_if(cuts.begin(), cuts.end(), isWithoutMemory);
  if (cut != cuts.end()) {
    *cut = std::move(origin.cut);
    cut->clear();
  }
  return out;
}

}  // namespace kerf
