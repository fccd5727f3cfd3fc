// Triangles that are there several times.
#pragma once

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// Opposite copies of a triangle cancel. Equal copies count several times in the chain, which is right where whole
/// solids coincide; where one is too many for its edges (a face stored twice in a scan) it goes. Entered in the report.
void dropDuplicates(Chain& chain, CloseReport& report);

}  // namespace kerf::internal
