// Removed volume of a cut field by tissue, and the number of pieces left.
#pragma once

#include <functional>
#include <span>

#include "geometry/field/brick_field.h"
#include "geometry/field/material_bricks.h"
#include "geometry/field/material_field.h"
#include "sim/object/baked_object.h"
#include "sim/run/files/haptic_summary.h"
#include "sim/run/files/run_manifest.h"

namespace kerf::internal {

/// Gives the 512 numbers of a brick's materials.
using MaterialsOf = std::function<void(const Vec3i& brick, std::span<std::uint8_t, kBrickNodes> out)>;

/// mm^3 by number: volume of the nodes as baked minus their volume as cut, as in the ledger of CutObject
/// (sim/object/node_volumes.h).   @param cut  the bricks that differ.
VolumeByNumber removedVolumes(const BrickField& phi0, const BrickField& cut, const MaterialsOf& materials);
/// The same where materials change because some was added: added material counts below 0.
VolumeByNumber removedVolumes(const BrickField& phi0, const BrickField& cut, const MaterialsOf& before,
                              const MaterialsOf& after);

/// The cut with its plane faces closed, where both parts are left and no kerf is lost: nodes beside such a face count
/// as whole. Nodes that a stroke changed stay as they are.
/// @param pieces  of the run.
BrickField withoutPlaneFaces(BrickField cut, const BrickField& phi0, std::span<const RunManifest::Piece> pieces);

/// mm^3 that two cuts of one object both remove: the lesser of the two, node by node.
double commonVolume(const BrickField& phi0, const BrickField& one, const BrickField& other);

/// mm^3 of the cut field outside the baked one with unknown material, such as a filling, regardless of any cut beside
/// it. Depths below a hundredth of a voxel are rounding.
/// @param known  bricks with known materials: they do not count.
double addedVolume(const BrickField& phi0, const BrickField& cut, const MaterialBricks& known);

struct PieceCount {
  std::size_t pieces = 0, crumbs = 0;  ///< crumbs: parts below 0.1 mm^3
};
/// Pieces of the object after a cut.   @param cut  the bricks that differ.
PieceCount countPieces(const BrickField& phi0, const BrickField& cut);

/// For a case: nodes without a label get the fallback, as in loadObject().
MaterialsOf materialsOf(const MaterialField& materials, Material fallback);
/// For an object in memory, kept by reference.
MaterialsOf materialsOf(const BakedObject& object);

}  // namespace kerf::internal
