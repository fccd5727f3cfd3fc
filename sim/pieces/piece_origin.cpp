#include "sim/pieces/piece_origin.h"

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

}  // namespace kerf
