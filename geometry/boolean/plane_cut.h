// A solid cut by planes, into what lies above all of them and the rest; both closed by flat faces. Above is the side to
// which a normal points.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/types.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct PlaneCutOptions {
  /// Of the part above all planes only the piece nearest to this point is cut off; its other pieces stay with the rest.
  std::optional<Vec3d> piece_at;
  PostOpOptions post_op;
};

struct PlaneCut {
  PostOpMesh above;        ///< of all planes
  PostOpMesh rest;         ///< below at least one
  double flatness_mm = 0;  ///< farthest that a vertex of a cut face lies from the planes, after rounding to float32
  double shift_mm = 0;     ///< the planes were moved so far along their normals, for float32's sake; most often 0
  int attempts = 1;
};

/// Both parts hold what postOperativeMesh() guarantees: vertices that are not cut stay bit for bit, the result is
/// closed, 2-manifold and free of self-intersections after rounding to float32, or it is refused.
/// @param planes  at least one, at most kMostCutPlanes; normals of any length but 0.   @pre source: as of
/// postOperativeMesh(). Errors: kBadValue for a plane without direction or not finite; kEmpty when nothing lies above,
/// or nothing below, with the heights at which the solid lies; kGeometry for planes that share no room, for pieces that
/// stand too close to be told apart (`piece_at`), and where float32 has no such mesh.
/// @cost  about 0.5 s for 100k triangles. @thread any; deterministic.
Expected<PlaneCut> cutByPlanes(const Mesh& source, std::span<const Plane> planes, const PlaneCutOptions& options = {},
                               const Progress& progress = {});

inline constexpr std::size_t kMostCutPlanes = 64;

}  // namespace kerf
