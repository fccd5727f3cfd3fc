// Cuts ragged gum off along the rim of a scan, on request only.
#pragma once

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// Removed parts of the rims.
struct Trimmed {
  std::size_t places = 0;  ///< connected along the rim
  std::size_t vertices = 0, triangles = 0;
  double area_mm2 = 0;
};

/// Removes the surface out of reach of a disc of this width: tongues and flakes of the rims narrower than the width. In
/// image processing terms, an opening of the surface by half the width, with lengths along edges. Of separated parts
/// the largest stays. Corners out of reach of the disc stay as well. Whole triangles go, no vertex moves; edges of the
/// rim finer than a quarter of the half width, or a median edge of the mesh, stay as they are.
/// @param rims  loops of the chain's boundary.   @param width_mm  > 0.   @cost  O(n log n).
Trimmed trimRims(Chain& chain, const std::vector<Loop>& rims, double width_mm);

}  // namespace kerf::internal
