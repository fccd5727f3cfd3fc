// Makes the chain closed: fills holes, extrudes rims to a base.
#pragma once

#include "geometry/base/error.h"
#include "preprocess/close/chain.h"
#include "preprocess/close/close.h"

namespace kerf::internal {

/// Closes every boundary loop of the chain: rims by a base, holes by a patch (see CloseOptions), and reports it.
/// Errors: kGeometry for a rim in CloseMode::kRepair, or no boundary to build on in kBase; kCancelled.
Expected<void> closeBoundary(Chain& chain, const CloseOptions& options, CloseReport& report, const Progress& progress);

/// The occlusal plane for the base of a scan without underside. Errors: as findOcclusalPlane(); kGeometry for a chain
/// without boundary.
Expected<OcclusalPlane> findPlaneOfScan(const Chain& chain, const CloseOptions& options);

}  // namespace kerf::internal
