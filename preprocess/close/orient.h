// Orientation of triangles and pieces.
#pragma once

#include "preprocess/close/chain.h"
#include "preprocess/close/edges.h"

namespace kerf::internal {

/// Turns triangles so that neighbours across two-sided edges agree; in every patch the minority turns. Entered in the
/// report.
void orientTriangles(Chain& chain, CloseReport& report);

/// Turns pieces that are inside out, each by its own volume, unless they lie inside another without crossing it: then
/// they bound a cavity. Cavities turn with their piece. Open pieces stay. Entered in the report.
/// @return true if the box of one piece lies in that of another: their winding numbers must be checked.
bool turnPieces(Chain& chain, CloseReport& report);

/// As edgeConnectedPieces(), from edge uses at hand.
Pieces piecesOf(std::size_t triangles, const std::vector<EdgeUse>& uses);

}  // namespace kerf::internal
