// Closes seams: boundaries that run along each other.
#pragma once

#include "geometry/base/error.h"
#include "preprocess/close/chain.h"

namespace kerf::internal {

/// Joins boundary vertices no farther apart than `tolerance` (the later one moves to the earlier), then splits boundary
/// edges at boundary vertices that lie within `tolerance` of them, so that seams meshed differently on either side fit
/// as well. Inner vertices never move; a vertex on an edge stays where it is, the split triangle gives way. Entered in
/// the report with the largest move. @pre no triangle repeats a vertex.
/// Errors: kGeometry for a heap: millions of boundary vertices that lie on each other or on each other's edges; the
/// chain is then unusable.   @cost  O(n log n) in the boundary; 0.1 s for 40 000 edges.
Expected<void> stitchSeams(Chain& chain, double tolerance, CloseReport& report);

}  // namespace kerf::internal
