// The post-operative mesh: the source minus what was removed plus what was added, exact where nothing was cut, ready
// for a printer.
#pragma once

#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/boolean/boolean.h"
#include "geometry/field/brick_field.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct PostOpOptions {
  Rgba8 cut_color = {214, 92, 64, 255};       ///< of cut faces
  Rgba8 source_color = {232, 222, 200, 255};  ///< of source faces when the source has no colours of its own
  /// A piece that the cut left over, smaller than both this many voxels and this share of the source's volume, is
  /// dropped and reported; never the largest one, and never a piece of the source that the cut did not touch.
  double crumb_voxels = 10, crumb_fraction = 1e-4;
};

struct PostOpReport {
  double source_volume_mm3 = 0, result_volume_mm3 = 0;
  double removed_volume_mm3 = 0;         ///< source - result as written (float32); with an added solid before rounding
  double added_volume_mm3 = 0;           ///< result - what the cut left; both count rounding, if any, as added
  std::size_t source_vertices_kept = 0;  ///< bit for bit
  std::size_t source_vertices_removed = 0;    ///< inside the cut, or covered by what was added
  std::size_t source_vertices_in_crumbs = 0;  ///< outside the cut, lost with a dropped crumb
  std::size_t cut_triangles = 0;              ///< on cut walls, and of what was added
  std::size_t pieces = 0;
  std::size_t cavities = 0;  ///< hollows inside the pieces, which a printer fills or leaves full of resin
  std::size_t crumbs_dropped = 0;
  double crumbs_volume_mm3 = 0;
  double crumb_mm3 = 0;        ///< cut-off parts below this were dropped
  double largest_move_mm = 0;  ///< of any new vertex, by rounding to float32 and mending what that broke
  /// Of the source: the booleans went through them; all, or those near the cut (Reach::kNear).
  std::size_t boolean_triangles = 0;
  int attempts = 1;  ///< > 1: the removed solid was shifted by some thousandths of a voxel
};

struct PostOpMesh {
  Mesh mesh;                    ///< float32-representable; source vertices first, in the source's order; coloured
  std::vector<char> is_cut;     ///< per triangle: on a cut wall
  std::vector<char> is_source;  ///< per vertex: a source vertex, bit for bit
  PostOpReport report;
};

/// source minus the material in `rho`, plus that in `added` if given (see removed_solid.h), rounded to float32, mended,
/// verified. Guarantees on success: closed, 2-manifold, outward, no self-intersection after rounding to float32; every
/// source vertex that lies outside the cut is there with its own coordinates and colour, but for those of dropped
/// crumbs, which are counted.
/// @pre source closed, 2-manifold, outward, free of self-intersections, coordinates representable in float32.
/// Fails with kGeometry rather than return a mesh that does not hold the guarantees. About 1 s for 100k triangles.
Expected<PostOpMesh> postOperativeMesh(const Mesh& source, const BrickField& rho, const PostOpOptions& options = {},
                                       const Progress& progress = {}, const BrickField* added = nullptr);

namespace internal {

/// What became of a cut, and why it can not be printed; empty: it can.
struct FinishedCut {
  PostOpMesh result;
  std::string why_not;
};
/// Paints, drops crumbs, rounds to float32, mends and verifies what a boolean left of `source`.
/// @param length_mm  of the clean-up: cleanUpForFloat32().   @param crumb_mm3  cut-off parts below it are dropped.
/// @param report  what is known already; of an added solid `has_added`.   Error kEmpty: nothing is left.
Expected<FinishedCut> finishCut(const Mesh& source, Difference cut, double length_mm, double crumb_mm3,
                                const PostOpOptions& options, PostOpReport report = {}, bool has_added = false);

}  // namespace internal
}  // namespace kerf
