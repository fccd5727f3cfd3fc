// Materials added to a case, as a run stores them: kerf cut --add, or the command in a session.
#pragma once

#include "geometry/field/material.h"
#include "geometry/field/material_bricks.h"
#include "sim/run/session/session_pieces.h"

namespace kerf::internal {

/// The bricks of the case with added material, from this session or an earlier one, with their current materials. Where
/// pieces meet in a brick, a node belongs to the piece that has most there.
/// @param objects  of the case, from objectsOf().
/// @param before  readRunMaterials() of the earlier run; empty: none.
/// @return empty: nothing was ever added.   @cost  as BrickStore::changedField().
MaterialBricks addedMaterials(const Objects& objects, const MaterialBricks& before, const MaterialTable& table);

}  // namespace kerf::internal
