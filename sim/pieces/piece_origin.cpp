#include "sim/pieces/piece_origin.h"

#include <algorithm>

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

PieceOrigin originOf(const CutObject& piece) {
  PieceOrigin out;
  out.id = out.of = piece.id;
  out.baked = piece.bricks().sharedBaked();
  out.plane_sides = piece.plane_sides;
  const BrickField& phi0 = out.baked->phi0();
  for (int s = 0; s < piece.slotCount(); ++s) {
    if (!piece.bricks().has(s)) continue;
    const CutObject::Slot& slot = piece.slot(s);
    (phi0.valuesAt(slot.brick) || slot.own ? out.bricks : out.interior).push_back(slot.brick);
    if (!slot.own) continue;
    BrickEdit& edit = out.cut.emplace_back();
    edit.brick = slot.brick;
    std::copy_n(slot.own, kBrickNodes, edit.phi.begin());
  }
  return out;
}

}  // namespace kerf
