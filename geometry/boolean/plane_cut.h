// Cuts a solid by planes into the part above all of them and the rest; flat faces close both. Above is the side that a
// normal points to. And drills a round hole.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/round_hole.h"
#include "geometry/base/types.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct PlaneCutOptions {
  /// Cuts off only the piece above all planes nearest to this point; other pieces stay with the rest.
  std::optional<Vec3d> piece_at;
  /// Width of material lost along the planes, mm: each part ends half of it away from them.
  double kerf_mm = 0;
  PostOpOptions post_op;
};

struct PlaneCut {
  PostOpMesh above;        ///< above all planes
  PostOpMesh rest;         ///< below at least one
  double flatness_mm = 0;  ///< largest distance of a vertex of a cut face from the planes, after rounding to float32
  double shift_mm = 0;     ///< shift of the planes along their normals, to fit float32; usually 0
  int attempts = 1;
};

/// Both parts hold the guarantees of postOperativeMesh(): uncut vertices stay bit for bit; the result is closed,
/// 2-manifold and free of self-intersections after rounding to float32. Otherwise an error.
/// @param planes  at least one, at most kMostCutPlanes; normals of any length but 0.   @pre source: as in
/// postOperativeMesh(). Errors: kBadValue for a plane without direction or not finite, or a negative kerf; kEmpty if
/// nothing lies above, or nothing below, with the heights of the solid; kGeometry for planes without common space, for
/// pieces too close to separate (`piece_at`), and if float32 has no such mesh.
/// @cost  about 0.5 s for 100k triangles. @thread any; deterministic.
Expected<PlaneCut> cutByPlanes(const Mesh& source, std::span<const Plane> planes, const PlaneCutOptions& options = {},
                               const Progress& progress = {});

inline constexpr std::size_t kMostCutPlanes = 64;

/// The solid minus a round hole, a prism of 64 sides inscribed in it: at most 1.3 um inside a hole of 2 mm. The
/// guarantees and errors of cutByPlanes(). None: the hole does not meet the solid.
/// @pre usable.   @cost  as a boolean: 0.2 s for 200k triangles. @thread any; deterministic.
Expected<std::optional<PostOpMesh>> withHole(const Mesh& source, const RoundHole& hole,
                                             const PostOpOptions& options = {});

}  // namespace kerf
