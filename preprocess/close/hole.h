// Fills one small hole.
#pragma once

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// Adds triangles whose boundary is the loop: the triangulation without new vertices that CGAL finds best (least
/// dihedral angle, then area; Liepa, SGP 2003), or, if it finds none, a fan around the loop's mean. It may cross the
/// mesh.
/// @return true unless the fan was needed.
bool fillHole(Chain& chain, const Loop& loop);

/// Adds the fan around the loop's mean.
void fanHole(Chain& chain, const Loop& loop);

}  // namespace kerf::internal
