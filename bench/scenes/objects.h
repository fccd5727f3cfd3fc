// Objects of simple geometry, their tissue, and queries on an object during a cut.
#pragma once

#include <memory>
#include <vector>

#include "geometry/field/brick_field.h"
#include "sim/object/cut_object.h"
#include "sim/step/step.h"

namespace kerf::scenes {

/// One tissue everywhere.
/// @param stiffness  N/mm^3.   @param friction  Coulomb.   @param energy  specific cutting energy, N/mm^2.
TissueTable oneTissue(double stiffness, double friction, double energy);

/// Signed distance to a box, mm, negative inside.   @param half  of its sides.
double boxDistance(const Vec3d& p, const Vec3d& center, const Vec3d& half);

/// A ball of that radius (mm) about `center`, baked.
Expected<std::shared_ptr<const BakedObject>> practiceSphere(const Vec3d& center, double radius, double voxel);

/// The highest tissue on a vertical line, mm; NaN: none.
double topAt(const BrickField& phi, double x, double y, const Box3& box);

/// Saw section through one side of an upright mandible: bone along x, at y = `y`, from 5 mm off the middle outwards, in
/// steps of 0.5 mm.
struct BoneAcross {
  double from = 0, to = 0;  ///< |x| of the first and the last bone, mm; from == 0: none
  double top = -1e9;        ///< the highest bone, mm
};
/// @param side  1: x > 0; -1: x < 0.
BoneAcross boneAcross(const BrickField& phi, double y, double side);

/// The current field: the baked field with its changes.
BrickField currentField(const CutObject& object);

/// Appends the current values of a brick.
void appendEdit(std::vector<BrickEdit>& edits, const CutObject::Slot& slot);

/// Reserves bricks for the next ticks, as a session does.
void reserveForTicks(CutObject& object);

}  // namespace kerf::scenes
