// The removed and the added material as closed meshes for an exact boolean.
//
// The naive removed solid {phi0 < 0 < phi} runs side by side with the source surface and never survives rounding to
// float32. So both functions extend it beyond the object by up to two voxels, where nothing is left to cut.
#pragma once

#include "geometry/field/brick_field.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// For geometry-only cuts: rho = max(psi, phi0 - 2h) in the bricks of psi, the union of all tool sweeps (mm, air
/// included). Its walls are the tool's own, so the rim on the source is crisp to some hundredths of a voxel.
BrickField removedFieldFromSweep(const BrickField& phi0, const BrickField& sweep);

/// For any cut: rho = max(-phi, phi0 - 2h) where phi differs from phi0, in its bricks and those beside the rim. Beyond
/// the rim rho continues in a straight line for two nodes, then it is at least eps = 0.1 h. Parts of the cut nowhere
/// deeper than eps stay in the object. The volume of a cut deeper than 0.4 voxels is accurate to 3 %.
BrickField removedFieldFromCut(const BrickField& phi0, const BrickField& phi);

/// The added field: the mirror image, from -phi0 and -phi. It reaches into the object.
BrickField addedFieldFromFill(const BrickField& phi0, const BrickField& phi);

/// Removes values near 0 that are nowhere negative: where material was both cut and added, each leaves such creases in
/// the field of the other. They must not become chips.
void clearAwayFromInside(BrickField& rho);

struct RemovedSolid {
  Mesh mesh;                      ///< closed, outward, double precision
  std::size_t parts_dropped = 0;  ///< parts below one voxel's volume, which would leave bubbles
  double dropped_volume_mm3 = 0;
};
/// Meshes {rho < 0} and drops its crumbs. @pre rho is balanced against chords (marching_cubes.h), as for all fields
/// above.
RemovedSolid meshRemovedSolid(const BrickField& rho);

}  // namespace kerf
