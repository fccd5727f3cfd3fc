// Undercuts of a model along the axis of insertion: their depth, their volume, and the axis with the least.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct UndercutOptions {
  /// Only the part above this plane counts, such as the teeth above the gum: it leaves out the walls of a base and its
  /// underside, which is one large undercut. The normal points to the part that counts. None: all.
  std::optional<Plane> above{};
  double voxel_mm = 0.1;  ///< spacing of the grid that finds undercuts. Notches narrower than it may be missed
  double most_mm = 5;     ///< deeper places get this value
};

/// Undercut depth of each vertex, mm, as a dental surveyor and its undercut gauge measure it: with the rod parallel to
/// the axis, the distance square to the axis from the place to the nearest rod that passes the model from above without
/// touching (Carr & Brown, McCracken's Removable Partial Prosthodontics: the survey line is where the rod touches, the
/// gauges are 0.25, 0.50 and 0.75 mm). In other words: at the height of the place, the distance to the outline of the
/// shadow of all material above that height. 0 where nothing stands above the place.
/// @param mesh  open or closed, unchanged. The walls of a sealed cavity are undercuts.
/// @param axis  unit, mesh frame: out of the model, against the movement of insertion.
/// The grid only finds the nearest rod; its place is then searched on the mesh. Measured on balls, cones and leaning
/// cylinders in any frame, at 0.1 mm: at most 0.003 mm too deep, and not too shallow.
/// Fails with kEmpty, kGeometry, kBadValue, kCancelled. Deterministic; parallel inside.
/// @cost  a mandible of 118 x 87 x 77 mm, 42 000 triangles, half of it undercut, at 0.1 mm: 0.33 s of one core, 48 MB.
Expected<std::vector<double>> undercutDepths(const Mesh& mesh, const Vec3d& axis, const UndercutOptions& options = {},
                                             const Progress& progress = {});

/// Volume of the block-out that removes all undercuts, mm3: the air below material along the axis, down to
/// `options.above`, or to the lowest vertex without it. Sampled on columns of voxel_mm.
/// @pre closed; an open surface fails with kGeometry.   @cost  as findPockets().
Expected<double> undercutVolume(const Mesh& solid, const Vec3d& axis, const UndercutOptions& options = {},
                                const Progress& progress = {});

struct AxisOptions {
  double cone_deg = 15;  ///< search within this angle of the start, at most 45
  UndercutOptions undercut{.voxel_mm = 0.4};
};
struct InsertionAxis {
  Vec3d axis = Vec3d::UnitZ();  ///< unit, out of the model
  double undercut_mm3 = 0;      ///< undercutVolume() along it
  double start_mm3 = 0;         ///< along the start
  std::size_t tried = 0;        ///< directions
};
/// Axis with the smallest undercutVolume() near `start`, to half a degree; of axes equal within 0.1 % of the start's
/// the one nearest to the start. Tries rings of directions 5 degrees apart, then smaller steps about the best. Finds a
/// local minimum narrower than 5 degrees only by chance. Without `undercut.above` the walls of a base decide.
/// Deterministic; parallel inside.   @cost  60 to 100 volumes: 1.4 s of one core on that mandible.
Expected<InsertionAxis> findInsertionAxis(const Mesh& solid, const Vec3d& start, const AxisOptions& options = {},
                                          const Progress& progress = {});

}  // namespace kerf
