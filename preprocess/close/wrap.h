// Shrink-wrap of a triangle soup: the last resort.
#pragma once

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf::internal {

/// Alpha wrap (Portaneri et al., SIGGRAPH 2022; CGAL): closed, 2-manifold, not crossing itself, outside the input by
/// about `offset_mm`, hollows narrower than `alpha_mm` bridged. No input vertex survives. Cost: seconds at alpha 1,
/// minutes at 0.2. Errors: kGeometry, kCancelled.
Expected<Mesh> wrapSoup(const Mesh& soup, double alpha_mm, double offset_mm, const Progress& progress);

}  // namespace kerf::internal
