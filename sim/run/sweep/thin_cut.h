// A cut between the nodes of the voxel grid: no node counts it, but the exported mesh lacks it.
#pragma once

#include "geometry/field/brick_field.h"

namespace kerf {

/// Volume of {max(psi, phi0) < 0}, mm^3, both fields trilinear between their nodes. A cell that surfaces cross is
/// integrated along 16^2 lines, exactly along each.
/// @param phi0  the baked field, mm, negative in tissue.
/// @param psi   of a sweep, mm, negative where the tool has been; on the nodes of phi0. All bricks with negative values
///   are stored.
/// @cost  0.1 us a node of psi's bricks, 5 us a crossed cell; parallel inside, same bits on any number of threads.
double sweptVolume(const BrickField& phi0, const BrickField& psi);

/// Volume that a stroke adds to a cut, mm^3, in the meshed field: 0 to the bit if it stays within the cut.
/// @param before  SweepCutter::sweep() of earlier strokes.   @param stroke  of the stroke alone.
/// @cost  that of sweptVolume() and removedFieldFromSweep() in and beside the bricks of the stroke, twice.
double strokeVolume(const BrickField& phi0, const BrickField& before, const BrickField& stroke);

/// Approximate volume that an export removes, mm^3: sweptVolume() of the meshed field, or 0 if the mesh would be a
/// crumb. The facets of the mesh cut corners off the tissue, so that it may lack a third more.
/// @param sweep  SweepCutter::sweep().   @cost  that of removedFieldFromSweep() and meshRemovedSolid() beside it.
double thinCutVolume(const BrickField& phi0, const BrickField& sweep);

}  // namespace kerf
