// Closes seams: boundaries that run along each other.
#pragma once

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// Joins boundary vertices no farther apart than `tolerance` (the later one moves to the earlier), then splits boundary
/// edges at boundary vertices that lie within `tolerance` of them, so that seams meshed differently on either side fit
/// as well. Inner vertices never move; a vertex on an edge stays where it is, the split triangle gives way. Entered in
/// the report with the largest move. @pre no triangle repeats a vertex. Cost: linear in the boundary.
void stitchSeams(Chain& chain, double tolerance, CloseReport& report);

}  // namespace kerf::internal
