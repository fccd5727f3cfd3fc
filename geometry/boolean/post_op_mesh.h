// The post-operative mesh: the source minus the removed volume plus the added one, exact where uncut, ready for a
// printer.
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
  Rgba8 cut_color = {214, 92, 64, 255};       ///< colour of cut faces
  Rgba8 source_color = {232, 222, 200, 255};  ///< colour of source faces if the source has none
  /// Drops and reports cut-off pieces smaller than both this many voxels and this share of the source's volume. Never
  /// drops the largest piece, nor an untouched piece of the source.
  double crumb_voxels = 10, crumb_fraction = 1e-4;
};

struct PostOpReport {
  double source_volume_mm3 = 0, result_volume_mm3 = 0;
  double removed_volume_mm3 = 0;         ///< source - result as written (float32); with an added solid before rounding
  double added_volume_mm3 = 0;           ///< result - source after the cut; both count rounding, if any, as added
  std::size_t source_vertices_kept = 0;  ///< bit for bit
  std::size_t source_vertices_removed = 0;    ///< inside the cut, or covered by the added solid
  std::size_t source_vertices_in_crumbs = 0;  ///< outside the cut, lost with a dropped crumb
  std::size_t cut_triangles = 0;              ///< on cut walls, and of the added solid
  std::size_t pieces = 0;
  std::size_t cavities = 0;  ///< hollows inside the pieces, which a printer fills or leaves full of resin
  std::size_t crumbs_dropped = 0;
  double crumbs_volume_mm3 = 0;
  double crumb_mm3 = 0;        ///< drop limit: smaller cut-off parts are gone
  double largest_move_mm = 0;  ///< largest move of a new vertex, by rounding to float32 and its repair
  /// Triangles of the source processed by the booleans: all, or those near the cut (Reach::kNear).
  std::size_t boolean_triangles = 0;
  int attempts = 1;  ///< > 1: after shifts of the removed solid by some thousandths of a voxel
};

struct PostOpMesh {
  Mesh mesh;                    ///< float32-representable; source vertices first, in the source's order; coloured
  std::vector<char> is_cut;     ///< per triangle: on a cut wall
  std::vector<char> is_source;  ///< per vertex: a source vertex, bit for bit
  PostOpReport report;
};

/// source minus the material in `rho`, plus that in `added` if given (see removed_solid.h), rounded to float32,
/// repaired, verified. Guarantees on success: closed, 2-manifold, outward, no self-intersection after rounding to
/// float32; every source vertex outside the cut keeps its coordinates and colour, except those of dropped crumbs, which
/// the report counts.
/// @pre source closed, 2-manifold, outward, free of self-intersections, coordinates representable in float32.
/// Fails with kGeometry if the guarantees do not hold. About 1 s for 100k triangles.
Expected<PostOpMesh> postOperativeMesh(const Mesh& source, const BrickField& rho, const PostOpOptions& options = {},
                                       const Progress& progress = {}, const BrickField* added = nullptr);

namespace internal {

/// A finished cut, and the reason why it can not be printed; empty if it can.
struct FinishedCut {
  PostOpMesh result;
  std::string why_not;
};
/// Paints a boolean's result of `source`, drops crumbs, rounds to float32, repairs and verifies.
/// @param length_mm  for cleanUpForFloat32().   @param crumb_mm3  drops smaller cut-off parts.
/// @param report  results so far; `has_added` for an added solid.   Error kEmpty: nothing is left.
Expected<FinishedCut> finishCut(const Mesh& source, Difference cut, double length_mm, double crumb_mm3,
                                const PostOpOptions& options, PostOpReport report = {}, bool has_added = false);

}  // namespace internal
}  // namespace kerf
