// What a cut field takes off an object, tissue by tissue, and in how many pieces it leaves it.
#pragma once

#include <functional>
#include <span>

#include "geometry/field/brick_field.h"
#include "geometry/field/material_bricks.h"
#include "geometry/field/material_field.h"
#include "sim/object/baked_object.h"
#include "sim/run/haptic_summary.h"

namespace kerf::internal {

/// Gives the 512 numbers of a brick's materials.
using MaterialsOf = std::function<void(const Vec3i& brick, std::span<std::uint8_t, kBrickNodes> out)>;

/// mm^3 by number: what the nodes stand for as baked less what they stand for as cut, as the ledger of CutObject counts
/// (sim/object/node_volumes.h).   @param cut  the bricks that differ.
VolumeByNumber removedVolumes(const BrickField& phi0, const BrickField& cut, const MaterialsOf& materials);
/// The same where materials are others after it, since something was added: of that there is less than 0.
VolumeByNumber removedVolumes(const BrickField& phi0, const BrickField& cut, const MaterialsOf& before,
                              const MaterialsOf& after);

/// mm^3 that two cuts of one object both take off: those of the lesser of the two, node by node.
double commonVolume(const BrickField& phi0, const BrickField& one, const BrickField& other);

/// mm^3 that a cut field has and the baked one has not, such as a filling, whatever was cut beside it, and of which
/// nobody knows the material. Depths below a hundredth of a voxel are rounding.
/// @param known  bricks whose materials are known: they do not count.
double addedVolume(const BrickField& phi0, const BrickField& cut, const MaterialBricks& known);

struct PieceCount {
  std::size_t pieces = 0, crumbs = 0;  ///< crumbs: parts below 0.1 mm^3
};
/// What the object is in.   @param cut  the bricks that differ.
PieceCount countPieces(const BrickField& phi0, const BrickField& cut);

/// Of a case: a node without a label is of the fallback, as loadObject() has it.
MaterialsOf materialsOf(const MaterialField& materials, Material fallback);
/// Of an object in memory, which is kept by reference.
MaterialsOf materialsOf(const BakedObject& object);

}  // namespace kerf::internal
