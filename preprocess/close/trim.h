// Cuts ragged gum off along the rim of a scan: only where it is asked for.
#pragma once

#include "preprocess/close/chain.h"

namespace kerf::internal {

/// What was taken.
struct Trimmed {
  std::size_t places = 0;  ///< connected along the rim
  std::size_t vertices = 0, triangles = 0;
  double area_mm2 = 0;
};

/// Takes what a disc of the width does not reach along the surface: tongues and flakes of the rims narrower than that.
/// In the words of image processing, an opening of the surface by half the width; lengths are measured along edges. Of
/// what then falls apart the largest part stays, and so do corners, which a disc does not reach into either. Whole
/// triangles go, no vertex moves; edges of the rim finer than a quarter of the half width, or a median edge of the
/// mesh, stay as they are.
/// @param rims  loops of the chain's boundary.   @param width_mm  > 0.   @cost  O(n log n).
Trimmed trimRims(Chain& chain, const std::vector<Loop>& rims, double width_mm);

}  // namespace kerf::internal
