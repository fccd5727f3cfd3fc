// A mesh elsewhere, still printable.
#pragma once

#include "geometry/base/error.h"
#include "geometry/base/types.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Moves in double precision and rounds to float32. If the surface then crosses itself, shifts by some
/// hundred-thousandths of a millimetre until it does not.
/// @pre free of self-intersections.   Error kGeometry: it crosses itself at any shift.
/// @cost  one selfIntersections(), usually. @thread any; deterministic.
Expected<Mesh> rigidlyMoved(const Mesh& mesh, const Rigid3& motion);

}  // namespace kerf
