// The plane teeth bite on, found from a scan.
#pragma once

#include <cstddef>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct OcclusalPlane {
  Vec3d normal = Vec3d::UnitZ();  ///< unit, out of the teeth
  Vec3d point = Vec3d::Zero();    ///< mm, on the plane
  std::size_t tips = 0;           ///< cusp tips and incisal edges it is fitted to
  double rms_mm = 0;              ///< RMS distance of these tips from the plane
};

/// Finds the plane through the cusp tips: local maxima of the height (nothing higher within 2 to 4 mm) are candidates;
/// of all planes through three of them that stand wide enough apart and tilt less than 45 degrees from `up`, the one
/// with most candidates within 1 mm and least above it wins; it is fitted to those by least squares, and all is done
/// again with heights along its normal, until nothing changes. Started from `up`, from the axis next to it, and from
/// the direction in which the mesh is flattest; most tips win. The curves of Spee and Wilson keep tips off any plane by
/// about a millimetre, hence the tolerance.
/// @param up  roughly out of the teeth: away from where the scan is open. Any length but zero.
/// Errors: kGeometry if fewer than six tips agree, or they stand in a line: a single tooth has no occlusal plane.
/// @cost 50 ms for a jaw of 50k triangles. @thread any; deterministic.
Expected<OcclusalPlane> findOcclusalPlane(const Mesh& mesh_mm, const Vec3d& up);

}  // namespace kerf
