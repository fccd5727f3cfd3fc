// Triangles that are there several times.
#pragma once

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// A closed surface that is there several times, the same way round, stays once: a file that was stored twice, a solid
/// that was copied onto itself. Each piece of surface is judged alone: a hollow solid whose outer shell is there twice
/// keeps its cavity, although a second solid in the same place would fill it. Works on chains that are not oriented
/// yet: else the steps that follow would take the square of the copies in time. Entered in the report. Cost: some
/// sorts.
void dropRepeatedSurfaces(Chain& chain, CloseReport& report);

/// Opposite copies of a triangle cancel, after turnPieces(): a face of a piece that is inside out lies back to back
/// with one of a piece that it overlaps. Equal copies count several times in the chain, which is right where whole
/// solids coincide; where one is too many for its edges (a face stored twice in a scan) it goes. Entered in the report.
void dropDuplicates(Chain& chain, CloseReport& report);

}  // namespace kerf::internal
