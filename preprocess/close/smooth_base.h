// Walls as a technician trims them: from a ragged rim down to a calm outline.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "preprocess/close/base.h"
#include "preprocess/close/chain.h"
#include "preprocess/close/close.h"

namespace kerf::internal {

/// Lengths in mm. `scale` is below 1 on objects smaller than dental ones; it shrinks all default lengths.
struct SmoothWalls {
  double smoothing_mm = 12;  ///< wave length below which the outline of the base is straightened, > 0
  double lip_mm = 0.3;       ///< extension of the scan in its own tangent plane; 0: the walls begin at the rim
  double scale = 1;
};

/// Gaps of a rim filled before the walls.
struct BridgedGaps {
  double rim_mm = 0;                 ///< length of the rim along them
  double widest_mm = 0;              ///< the widest mouth
  std::vector<BridgedPlace> places;  ///< one per gap
  std::vector<WideSpan> spans;       ///< all spans wider than any mouth
};

/// Fills narrow fjords of the rims: where two of its vertices lie within 4 mm, the way between them along the rim is
/// more than three times as long, and the straight line leads over empty space at both ends (outward conormals). The
/// longest first; none overlap. A bridge adds triangles between rim vertices and moves nothing. A fjord may widen
/// behind its mouth, as the socket of a tooth does: the bridge fills all of it.
/// @return the remaining rims, in the given order. Errors: kCancelled; the chain may then hold half of the bridges.
/// @cost O(n^2) in the vertices of a rim, 5000 at most: 50 ms.
Expected<std::vector<Loop>> bridgeFjords(Chain& chain, const std::vector<Loop>& rims, double scale, BridgedGaps& gaps,
                                         const Progress& progress);

/// Adds a lip and three wall curves below each rim, each smoother than the one above: 0.5, 1 and 2 mm down, smoothed
/// below wave lengths of 2, 4 and `smoothing_mm` mm. A curve T is the closed polygon that minimises
///   sum m rho(|T - R|) + (L / 2 pi)^4 sum m rho(|T''|),   rho Huber's function,
/// over the rim's samples R in the plane of the base, by eight rounds of reweighting; lengths are measured on the T of
/// the round before, so that folds collapse and corners stay.
/// @return the lowest curves, one per rim, above frame.level: extrudeToBase() continues from them.
/// Errors: kGeometry for a rim without extent, kCancelled; the chain is then unusable.
/// @cost about 50 ms for a rim of 400 mm; a rim of more than 2 m takes no longer than one of 2 m, in coarser steps. One
/// thread; the same bits for the same input.
Expected<std::vector<Loop>> addSmoothWalls(Chain& chain, const std::vector<Loop>& rims, const BaseFrame& frame,
                                           const SmoothWalls& walls, const Progress& progress);

}  // namespace kerf::internal
