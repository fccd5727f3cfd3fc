// Gives a scan without underside a flat base: walls straight down from its rims, and a cap, or a plate below.
#pragma once

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "preprocess/close/chain.h"

namespace kerf::internal {

/// The plane of a base: {x : w . x = level}, `w` pointing out of the model; (u, v, w) is right-handed and orthonormal.
struct BaseFrame {
  Vec3d u, v, w;
  double level = 0;    ///< mm along w
  double ceiling = 0;  ///< mm along w, below `level`: end of the walls on the plate
};

/// A frame with the given unit vector as w. A w within 1e-9 of a coordinate axis becomes that axis, exactly: then the
/// base is exactly flat in float32 as well. Otherwise its vertices lie within half a float32 step of it per coordinate
/// (4e-6 mm each, up to 64 mm from the origin).
BaseFrame baseFrame(const Vec3d& w);

/// Adds walls from the rims along w to the plane and the part of the plane they enclose; `on_plate`: walls to
/// `ceiling`, and a plate from there to `level` under the convex outline of the rims. Either way the rims are no longer
/// boundary. Rims that cross themselves in projection are allowed: the crossings become vertices (rounded to float32,
/// repeated until nothing crosses), and a face the rims wind around k times is added |k| times. On a mesh with vertex
/// colours a wall begins with a narrow row of triangles, so that the rim's colours end there and do not run down it.
/// @pre  frame.ceiling (on_plate) or frame.level is beyond all rim vertices, and ceiling < level.
/// Errors: kGeometry if the projection could not be triangulated, kCancelled; the chain is then unchanged.
Expected<void> extrudeToBase(Chain& chain, const std::vector<Loop>& rims, const BaseFrame& frame, bool on_plate,
                             const Progress& progress);

}  // namespace kerf::internal
