#include "sim/pieces/plane_parts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "sim/object/for_each.h"
#include "sim/pieces/make_piece.h"

namespace kerf {
namespace {

struct SideBricks {
  PieceBricks bricks;
  bool has_inside = false;
};

// A slot on one side: gone, as it was, or with new values.
enum class Fate : std::uint8_t { kGone, kKept, kChanged };

Fate fateOf(const BrickSlot& slot, const BrickField& phi0, const CutPlanes& planes, bool is_above, BrickEdit& edit) {
  const Vec3i base = slot.brick * kBrickSide;
  const double half = 0.5 * (kBrickSide - 1) * phi0.voxel();
  const double middle = planes.height(phi0.position(base) + Vec3d::Constant(half), is_above);
  const double reach = std::sqrt(3.0) * half;
  const double background = static_cast<double>(phi0.background());
  if (middle + reach < -background) return Fate::kGone;
  if (middle - reach > -static_cast<double>(slot.least)) return Fate::kKept;

  bool is_changed = false;
  edit.brick = slot.brick;
  for (int n = 0; n < kBrickNodes; ++n) {
    const Vec3i node = base + Vec3i{n >> 6, n >> 3 & 7, n & 7};
    const auto i = static_cast<std::size_t>(n);
    edit.phi[i] = planePartValue(slot.phi[n], planes.height(phi0.position(node), is_above), phi0.background());
    is_changed |= edit.phi[i] != slot.phi[n];
  }
  return is_changed ? Fate::kChanged : Fate::kKept;
}

SideBricks bricksOn(const CutObject& whole, const CutPlanes& planes, bool is_above, bool is_parallel) {
  const BrickField& phi0 = whole.baked().phi0();
  std::vector<int> slots;
  for (int s = 0; s < whole.slotCount(); ++s)
    if (whole.bricks().has(s)) slots.push_back(s);
  std::sort(slots.begin(), slots.end(),
            [&](int a, int b) { return coordKey(whole.slot(a).brick) < coordKey(whole.slot(b).brick); });

  constexpr std::size_t kLot = 256;
  std::vector<SideBricks> lots((slots.size() + kLot - 1) / kLot);
  internal::forEach(lots.size(), is_parallel, [&](std::size_t l) {
    SideBricks& out = lots[l];
    for (std::size_t n = l * kLot; n < std::min(slots.size(), (l + 1) * kLot); ++n) {
      const BrickSlot& slot = whole.slot(slots[n]);
      BrickEdit edit;
      const Fate fate = fateOf(slot, phi0, planes, is_above, edit);
      if (fate == Fate::kGone) continue;
      const float* const values = fate == Fate::kChanged ? edit.phi.data() : slot.phi;
      out.has_inside = out.has_inside || std::any_of(values, values + kBrickNodes, [](float v) { return v < 0; });
      const bool is_constant = fate == Fate::kKept && !slot.own && !phi0.valuesAt(slot.brick) && slot.phi[0] < 0;
      if (is_constant) {
        out.bricks.interior.push_back(slot.brick);
        continue;
      }
      out.bricks.bricks.push_back(slot.brick);
      out.bricks.at_edge.push_back(slot.brick);
      if (fate == Fate::kChanged) out.bricks.changed.push_back(edit);
    }
  });

  SideBricks all;
  const auto append = [](auto& to, auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  for (const SideBricks& lot : lots) {
    append(all.bricks.bricks, lot.bricks.bricks);
    append(all.bricks.interior, lot.bricks.interior);
    append(all.bricks.changed, lot.bricks.changed);
    append(all.bricks.at_edge, lot.bricks.at_edge);
    all.has_inside |= lot.has_inside;
  }
  return all;
}

std::shared_ptr<PieceOrigin> originOfPart(const CutObject& part, const CutObject& whole, PieceBricks bricks) {
  auto out = std::make_shared<PieceOrigin>();
  out->id = part.id;
  out->of = whole.id;
  out->baked = part.bricks().sharedBaked();
  out->plane_sides = part.plane_sides;
  std::size_t next = 0;  // both lists are in order of their bricks
  std::vector<int> own;
  for (int s = 0; s < part.slotCount(); ++s)
    if (part.bricks().has(s) && part.slot(s).own) own.push_back(s);
  std::sort(own.begin(), own.end(),
            [&](int a, int b) { return coordKey(part.slot(a).brick) < coordKey(part.slot(b).brick); });
  for (const int s : own) {
    const BrickSlot& slot = part.slot(s);
    while (next < bricks.changed.size() && coordKey(bricks.changed[next].brick) < coordKey(slot.brick)) ++next;
    if (next < bricks.changed.size() && bricks.changed[next].brick == slot.brick) continue;
    BrickEdit& edit = out->cut.emplace_back();
    edit.brick = slot.brick;
    std::copy_n(slot.own, kBrickNodes, edit.phi.begin());
  }
  out->bricks = std::move(bricks.bricks);
  out->interior = std::move(bricks.interior);
  out->near_others = std::move(bricks.changed);
  return out;
}

}  // namespace

std::unique_ptr<ObjectPieces> makePlaneParts(const CutObject& whole, const CutPlanes& planes, PlaneKeep keep,
                                             std::uint32_t cut, std::uint32_t first_id, bool is_parallel) {
  std::vector<bool> sides;
  if (keep != PlaneKeep::kBelow) sides.push_back(true);
  if (keep != PlaneKeep::kAbove) sides.push_back(false);

  auto out = std::make_unique<ObjectPieces>();
  std::vector<CutObject> parts;
  std::array<double, 256> lost = whole.bricks().countVolumes();
  for (const bool is_above : sides) {
    SideBricks side = bricksOn(whole, planes, is_above, is_parallel);
    if (!side.has_inside) return nullptr;
    CutObject part = makePiece(whole, side.bricks, nullptr, is_parallel);
    part.id = first_id + static_cast<std::uint32_t>(parts.size());
    auto list = std::make_shared<std::vector<PlaneSide>>();
    if (whole.plane_sides) *list = *whole.plane_sides;
    list->push_back({.cut = cut, .is_above = is_above, .planes = planes});
    part.plane_sides = std::move(list);
    const std::array<double, 256> kept = part.bricks().countVolumes();
    for (std::size_t m = 0; m < lost.size(); ++m) lost[m] -= kept[m];
    out->origins.push_back(originOfPart(part, whole, std::move(side.bricks)));
    parts.push_back(std::move(part));
  }

  // Without a kerf both parts together are the whole, but for the rounding of nodes at the plane.
  const bool loses = keep != PlaneKeep::kBoth || planes.kerf_mm > 0 || planes.hasHole();
  double sum = 0;
  for (std::size_t m = 0; m < lost.size(); ++m) {
    lost[m] = loses ? std::max(lost[m], 0.0) : 0.0;
    parts.front().removed_before_mm3[m] = whole.removed_before_mm3[m] + whole.removed_mm3[m] + lost[m];
    sum += lost[m];
  }
  out->parts = prepareSplit(std::move(parts));
  out->parts->is_plane_cut = true;
  out->parts->lost_mm3 = sum;
  return out;
}

}  // namespace kerf
