#include "sim/pieces/split_object.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "sim/object/for_each.h"
#include "sim/pieces/make_piece.h"
#include "sim/pieces/split_field.h"

namespace kerf {
namespace {

// Copies the edited bricks of the piece alone, except those near other pieces.
// @param near_others  in order of their bricks.
void copyCut(const CutObject& piece, const PieceFinder& finder, const std::vector<BrickEdit>& near_others,
             std::vector<BrickEdit>& out) {
  const auto isNearOthers = [&](const Vec3i& brick) {
    const auto known =
        std::lower_bound(near_others.begin(), near_others.end(), coordKey(brick),
                         [](const BrickEdit& edit, std::uint64_t key) { return coordKey(edit.brick) < key; });
    return known != near_others.end() && known->brick == brick;
  };

  const BrickField& changed = finder.field().changed();
  std::vector<int> slots;
  for (std::size_t c = 0; c < changed.brickCount(); ++c) {
    const int slot = piece.find(changed.brickCoord(c));
    if (slot >= 0 && piece.slot(slot).own && !isNearOthers(changed.brickCoord(c))) slots.push_back(slot);
  }

  out.resize(slots.size());
  for (std::size_t c = 0; c < slots.size(); ++c) {
    const CutObject::Slot& slot = piece.slot(slots[c]);
    out[c].brick = slot.brick;
    std::copy_n(slot.own, kBrickNodes, out[c].phi.begin());
  }
}

}  // namespace

std::unique_ptr<ObjectPieces> makePieces(const CutObject& whole, PieceFinder& finder, std::uint32_t first_id,
                                         std::size_t most, PiecePool* pool, bool is_parallel) {
  const PieceList& list = finder.find();
  const std::size_t count = list.pieces.size();
  if (count == 0 || count > most || count + list.crumbs.size() == 1) return nullptr;

  auto out = std::make_unique<ObjectPieces>();
  out->crumbs = list.crumbs.size();
  for (const Piece& crumb : list.crumbs) out->crumb_measure.add(crumb.measure);

  std::vector<PieceBricks> bricks = bricksOfPieces(finder, count, is_parallel, pool ? &pool->lists : nullptr);
  if (count == 1) {
    out->without_crumbs = bricks.front().changed;
    if (pool) pool->lists.takeBack(std::move(bricks.front()));
    return out;
  }

  // Each on its own, on all cores: neither reads the results of the other.
  std::vector<std::optional<CutObject>> made(count);
  out->origins.resize(count);
  internal::forEach(count, is_parallel, [&](std::size_t n) {
    std::unique_ptr<CutObject> blank;
    if (pool && n < pool->blanks.size()) blank = std::move(pool->blanks[n]);
    CutObject& part = made[n].emplace(makePiece(whole, bricks[n], std::move(blank), is_parallel));
    part.id = first_id + static_cast<std::uint32_t>(n);
    if (n == 0)
      for (std::size_t m = 0; m < whole.removed_mm3.size(); ++m)
        part.removed_before_mm3[m] = whole.removed_before_mm3[m] + whole.removed_mm3[m];

    auto origin = std::make_shared<PieceOrigin>();
    origin->id = part.id;
    origin->of = whole.id;
    origin->baked = part.bricks().sharedBaked();
    origin->plane_sides = part.plane_sides;
    if (pool && n < pool->cuts.size()) origin->cut = std::move(pool->cuts[n]);
    copyCut(part, finder, bricks[n].changed, origin->cut);
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
