// Repeated triangles.
#pragma once

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// Reduces several equal copies of a closed surface to one: a file stored twice, a solid copied onto itself. Judges
/// each piece of surface alone: a hollow solid with a double outer shell keeps its cavity, although a second solid in
/// the same place would fill it. Runs before orientation, because the later steps take the square of the copies in
/// time. Entered in the report. Cost: some sorts.
void dropRepeatedSurfaces(Chain& chain, CloseReport& report);

/// Opposite copies of a triangle cancel, after turnPieces(): a face of a piece that is inside out lies back to back
/// with one of a piece that it overlaps. Equal copies count several times in the chain, as coinciding solids require. A
/// copy that is too many for its edges (a face stored twice in a scan) goes. Entered in the report.
void dropDuplicates(Chain& chain, CloseReport& report);

}  // namespace kerf::internal
