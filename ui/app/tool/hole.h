// A planned hole: place, axis and depth; the room for the tool, and the walls that stay.
//
// All rays meet the surface as it is now. World frame, mm.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/tool/tool.h"
#include "ui/app/view/live_scene.h"

namespace kerf {

struct Hole {
  std::uint32_t object = 0;     ///< CutObject::id
  Vec3d entry = Vec3d::Zero();  ///< on the surface: the depth counts from here
  Vec3d axis = Vec3d::UnitZ();  ///< unit, out of the material
  double depth = 0;             ///< of the tip
  bool operator==(const Hole&) const = default;
};

/// A tool that drills along its axis.
struct DrillShape {
  double radius = 0;  ///< of the hole
  double point = 0;   ///< height above the tip where it has that radius
  double widest = 0;  ///< radius of the whole tool
  double top = 0;     ///< height of the whole tool
  std::vector<RevolvedProfile::Point> outline;

  /// Error kUnsupported: no bur, or its end does not cut.
  static Expected<DrillShape> of(const Tool& tool);
  /// Lowest height where the tool is at least as wide as `r`; infinite if nowhere.
  double lowestAt(double r) const;
};

struct HoleRoom {
  double most_depth = std::numeric_limits<double>::infinity();  ///< deeper, a wider part meets the surface
  double start = 0;                                             ///< height of the tip over the entry, in air
};
HoleRoom roomFor(const Hole& hole, const DrillShape& shape, const LiveScene& scene);

/// Depth of the tip at which the full width has left the material. None: the axis leaves it nowhere.
std::optional<double> depthThrough(const Hole& hole, const DrillShape& shape, const LiveScene& scene);

struct HoleWalls {
  std::optional<double> beneath;  ///< between the tip and the other side; below 0 it comes out; none: no other side
  std::optional<double> beside;   ///< thinnest wall around the hole; below 0 it breaks out
  std::optional<double> edge;     ///< from the axis to the nearest side of the model, just under the surface
};
/// @cost  a few ms for a jaw.
HoleWalls wallsOf(const Hole& hole, const DrillShape& shape, const LiveScene& scene);

}  // namespace kerf
