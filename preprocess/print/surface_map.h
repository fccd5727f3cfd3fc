// A number for each vertex of a mesh, in mm: its colours, its legend, and its extremes for a report.
#pragma once

#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Values between the ends of the ramp of mapColour(). The dark end is the one to look at: {0, 1} for the depth of an
/// undercut, {3, 0.5} for the thickness of a wall.
struct MapRange {
  double light_mm = 0, dark_mm = 1;  ///< not equal

  Rgba8 colour(double mm) const;
};

struct LegendRow {
  double mm;
  Rgba8 colour;
};
/// Evenly spaced from light to dark, both ends included. @pre rows >= 2.
std::vector<LegendRow> legendTable(const MapRange& range, int rows = 6);

/// One colour per value, for Mesh::vertex_colors.
std::vector<Rgba8> mapColours(std::span<const double> values_mm, const MapRange& range);

struct SurfaceNumbers {
  double least_mm = 0, most_mm = 0;
  Vec3d least_at = Vec3d::Zero(), most_at = Vec3d::Zero();  ///< the first such vertex
  double over_mm2 = 0;                                      ///< area where the value is above the limit
  double under_mm2 = 0;                                     ///< and below it
};

/// Between vertices values are linear, and the areas exact for that. Vertices without a triangle do not count.
/// @pre one finite value per vertex.
SurfaceNumbers surfaceNumbers(const Mesh& mesh, std::span<const double> values_mm, double limit_mm);

}  // namespace kerf
