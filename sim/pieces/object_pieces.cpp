#include "sim/pieces/object_pieces.h"

#include <algorithm>
#include <new>
#include <optional>

#include "sim/object/for_each.h"
#include "sim/object/huge_pages.h"
#include "sim/pieces/cut_size.h"
#include "sim/pieces/make_piece.h"

namespace kerf {

BrickField PieceOrigin::field() const {
  const BrickField& phi0 = baked->phi0();
  BrickField out(phi0.voxel(), phi0.background(), phi0.interior());
  out.reserve(bricks.size());
  for (const Vec3i& c : interior) out.markInterior(c);
  for (const Vec3i& c : bricks)
    if (const BrickValues* values = phi0.valuesAt(c)) out.add(c, *values);
  for (const auto* edits : {&cut, &near_others})
    for (const BrickEdit& edit : *edits) out.brick(out.touch(edit.brick)) = edit.phi;
  return out;
}

void PiecePool::reserve(const std::shared_ptr<const BakedObject>& baked, const PieceFinder& finder,
                        std::size_t bricks) {
  constexpr std::size_t kPieces = 2;
  blanks.resize(kPieces);
  cuts.resize(kPieces);
  const std::size_t edited = finder.field().changed().brickCount();
  // Their own, beside those that are free afterwards: what was cut, and of it what is near the other one. More than is
  // wanted now, once for a whole cut.
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
  for (std::vector<BrickEdit>& cut : cuts)
    if (cut.capacity() == 0) {
      cut = std::move(origin.cut);
      cut.clear();
      break;
    }
  return out;
}

std::unique_ptr<ObjectPieces> makePieces(const CutObject& whole, PieceFinder& finder, std::uint32_t first_id,
                                         std::size_t most, PiecePool* room, bool is_parallel) {
  const PieceList& list = finder.find();
  const std::size_t count = list.pieces.size();
  if (count == 0 || count > most || count + list.crumbs.size() == 1) return nullptr;
  auto out = std::make_unique<ObjectPieces>();
  out->crumbs = list.crumbs.size();
  for (const Piece& crumb : list.crumbs) out->crumb_measure.add(crumb.measure);
  std::vector<PieceBricks> bricks = bricksOfPieces(finder, count, is_parallel, room ? &room->lists : nullptr);
  if (count == 1) {
    out->without_crumbs = bricks.front().changed;
    if (room) room->lists.takeBack(std::move(bricks.front()));
    return out;
  }
  // Each on its own, on as many cores as there are: neither reads what the other makes.
  std::vector<std::optional<CutObject>> made(count);
  out->origins.resize(count);
  internal::forEach(count, is_parallel, [&](std::size_t n) {
    CutObject& part = made[n].emplace(makePiece(
        whole, bricks[n], room && n < room->blanks.size() ? std::move(room->blanks[n]) : nullptr, is_parallel));
    part.id = first_id + static_cast<std::uint32_t>(n);
    auto origin = std::make_shared<PieceOrigin>();
    origin->id = part.id;
    origin->of = whole.id;
    origin->baked = part.bricks().sharedBaked();
    // What was cut before, and is the piece's alone.
    const BrickField& changed = finder.field().changed();
    std::vector<const float*> cut;
    std::vector<Vec3i> where;
    for (std::size_t c = 0; c < changed.brickCount(); ++c) {
      const Vec3i& brick = changed.brickCoord(c);
      const int slot = part.find(brick);
      if (slot < 0 || !part.slot(slot).own) continue;
      const auto known =
          std::lower_bound(bricks[n].changed.begin(), bricks[n].changed.end(), coordKey(brick),
                           [](const BrickEdit& edit, std::uint64_t key) { return coordKey(edit.brick) < key; });
      if (known != bricks[n].changed.end() && known->brick == brick) continue;
      where.push_back(brick);
      cut.push_back(part.slot(slot).own);
    }
    if (room && n < room->cuts.size()) origin->cut = std::move(room->cuts[n]);
    origin->cut.resize(cut.size());
    for (std::size_t c = 0; c < cut.size(); ++c) {
      origin->cut[c].brick = where[c];
      std::copy_n(cut[c], kBrickNodes, origin->cut[c].phi.begin());
    }
    origin->bricks = std::move(bricks[n].bricks);
    origin->interior = std::move(bricks[n].interior);
    origin->near_others = std::move(bricks[n].changed);
    out->origins[n] = std::move(origin);
  });
  std::vector<CutObject> parts;
  parts.reserve(count);
  for (std::optional<CutObject>& part : made) parts.push_back(std::move(*part));
  out->parts = prepareSplit(std::move(parts));
  return out;
}

}  // namespace kerf
