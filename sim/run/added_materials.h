// The materials of what was added to a case, as a run keeps them: kerf cut --add, or the command in a session.
#pragma once

#include "geometry/field/material.h"
#include "geometry/field/material_bricks.h"
#include "sim/run/session_pieces.h"

namespace kerf::internal {

/// The bricks of the case in which something was added, in this session or before it, with the materials that they have
/// now. Where pieces meet in a brick, a node is of that piece which has most there.
/// @param objects  of the case, as objectsOf() finds them.
/// @param before  readRunMaterials() of the run that is gone on from; empty: none.
/// @return empty: nothing was ever added.   @cost  as BrickStore::changedField().
MaterialBricks addedMaterials(const Objects& objects, const MaterialBricks& before, const MaterialTable& table);

}  // namespace kerf::internal
