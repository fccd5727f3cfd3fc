// The removed material as a closed mesh that an exact boolean can subtract; the added one that it can unite.
//
// The naive removed solid {phi0 < 0 < phi} runs side by side with the source surface and never survives rounding to
// float32. Both functions therefore let it stick out of the object by up to two voxels, where nothing is left to cut.
#pragma once

#include "geometry/field/brick_field.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// For geometry-only cuts: rho = max(psi, phi0 - 2h) in the bricks of psi, the union of all tool sweeps (mm, air
/// included). Its walls are the tool's own, so the rim on the source is crisp to some hundredths of a voxel.
BrickField removedFieldFromSweep(const BrickField& phi0, const BrickField& sweep);

/// For any cut: rho = max(-phi, phi0 + eps - phi, phi0 - 2h), eps = 0.1 h, in the bricks of phi that differ from phi0.
/// Material cut by less than eps stays. The rim is good to some tenths of a voxel.
BrickField removedFieldFromCut(const BrickField& phi0, const BrickField& phi);

/// What was added: the mirror image, rho = max(phi, phi - phi0 + eps, -phi0 - 2h), which reaches into the object.
BrickField addedFieldFromFill(const BrickField& phi0, const BrickField& phi);

/// Takes away what is nearly 0 and nowhere negative: where material was both cut and added, each leaves such creases in
/// the field of the other, and chord balance (marching_cubes.h) would make chips of them.
void clearAwayFromInside(BrickField& rho);

struct RemovedSolid {
  Mesh mesh;                      ///< closed, outward, double precision
  std::size_t parts_dropped = 0;  ///< parts below one voxel's volume, which would leave bubbles
  double dropped_volume_mm3 = 0;
};
/// Meshes {rho < 0} and drops its crumbs.
RemovedSolid meshRemovedSolid(const BrickField& rho);

}  // namespace kerf
