// A baked field with changed bricks on top: a subscriber's copy of the object.
#pragma once

#include "geometry/field/brick_field.h"
#include "sim/object/brick_edit.h"

namespace kerf {

/// The current field phi: the changed bricks where there are any, the baked field phi0 elsewhere. Many threads may read
/// at once; set() needs exclusive access.
class OverlayField {
 public:
  /// @param phi0  kept by reference, must outlive this and not change.
  explicit OverlayField(const BrickField& phi0)
      : phi0_(phi0), changed_(phi0.voxel(), phi0.background(), phi0.interior()) {}

  double voxel() const { return phi0_.voxel(); }
  float background() const { return phi0_.background(); }
  float interior() const { return phi0_.interior(); }

  /// Values of a brick; null: constantAt(). Valid until the next set().
  const BrickValues* valuesAt(const Vec3i& brick) const {
    if (const BrickValues* values = changed_.valuesAt(brick)) return values;
    return phi0_.valuesAt(brick);
  }
  float constantAt(const Vec3i& brick) const { return phi0_.constantAt(brick); }
  /// Value at a node, mm.
  float at(const Vec3i& node) const {
    const Vec3i c = brickOf(node);
    const BrickValues* values = valuesAt(c);
    return values ? (*values)[static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]))] : constantAt(c);
  }

  void set(const BrickEdit& edit) { changed_.brick(changed_.touch(edit.brick)) = edit.phi; }

  const BrickField& baked() const { return phi0_; }
  const BrickField& changed() const { return changed_; }
  /// Both in one field: a copy of the baked one with the changed bricks in it.
  BrickField flattened() const {
    BrickField out = phi0_;
    for (std::size_t b = 0; b < changed_.brickCount(); ++b)
      out.brick(out.touch(changed_.brickCoord(b))) = changed_.brick(b);
    return out;
  }

 private:
  const BrickField& phi0_;
  BrickField changed_;
};

}  // namespace kerf
