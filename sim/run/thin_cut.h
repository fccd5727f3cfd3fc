// A cut between the nodes of the voxel grid: no node counts it, and the exported mesh lacks it all the same.
#pragma once

#include "geometry/field/brick_field.h"

namespace kerf {

inline constexpr double kUnchanged = 1e-6;  ///< mm^3; a smaller volume counts as none

/// Volume of {max(psi, phi0) < 0}, mm^3, both fields trilinear between their nodes. A cell that both surfaces cross, or
/// one of them, has 16^3 samples.
/// @param phi0  the baked field, mm, negative in tissue.
/// @param psi   of a sweep, mm, negative where the tool has been; on the nodes of phi0. All bricks
///   that it is negative in are stored.
/// @cost  0.1 us a node of psi's bricks, 10 us a cell that is crossed; parallel inside, same bits on any number of
/// threads.
double sweptVolume(const BrickField& phi0, const BrickField& psi);

/// About the volume that an export takes off, mm^3: sweptVolume() of the field that is meshed, or 0 if the mesh would
/// be a crumb. Up to a quarter below that of the mesh, whose facets cut corners off the tissue.
/// @param sweep  SweepCutter::sweep().   @cost  that of removedFieldFromSweep() and meshRemovedSolid() beside it.
double thinCutVolume(const BrickField& phi0, const BrickField& sweep);

}  // namespace kerf
