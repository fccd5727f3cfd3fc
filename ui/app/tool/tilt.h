// A tilted tool: leant away from the surface normal about its contact point.
//
// The lean has a fixed world direction, as a hand holds a handpiece: it stays when the camera turns. Mouse moves and
// degrees set it in the view: azimuth 0 leans the shank to the right of the picture, 90 to its upper edge.
//
// Depth and force of a stroke still follow the normal (sim/hand/mouse_hand.h): the tool's deepest point stops at the
// depth below the surface as loaded. From its contact, the tool goes in along its own axis.
#pragma once

#include <limits>
#include <numbers>
#include <vector>

#include "geometry/tool/tool.h"
#include "ui/app/tool/stroke.h"
#include "ui/app/view/camera.h"

namespace kerf {

struct Tilt {
  static constexpr double kMost = 75 * std::numbers::pi / 180;  ///< rad

  double angle = 0;                ///< between the tool's axis and the normal, rad, 0 to kMost
  Vec3d towards = Vec3d::UnitX();  ///< unit, world: lean direction of the shank
  bool isUpright() const { return !(angle > 0); }
};

/// @param angle  rad, clamped to 0 .. kMost.   @param azimuth  in the view, rad.
Tilt tiltInView(const Camera& camera, double angle, double azimuth);
/// Lean direction in the view, rad, -pi to pi; 0 when it points at the viewer or away.
double azimuthInView(const Camera& camera, const Tilt& tilt);
/// Tilt after a pointer move in pixels (y downwards): half a degree each, in the direction of the move.
Tilt tiltedBy(const Tilt& tilt, const Camera& camera, double dx, double dy);
/// Exit direction of the tool from tissue with that normal: unit. A tilt towards the normal itself leans any way.
Vec3d tiltedAxis(const Tilt& tilt, const Vec3d& normal);

/// First contact of a tool at any attitude with a flat surface: the farthest point of its cutting part.
class TouchPoints {
 public:
  /// Uses the outline of a tool of revolution, within 0.05 um; the vertices of a mesh; the box about a blade's teeth
  /// and their stroke.
  explicit TouchPoints(const Tool& tool);
  /// @param direction  unit, tool frame: into the surface.   @param up_to  counts points up to this height above the
  /// tip
  ///   only, mm.   @return  tool frame, mm.
  Vec3d farthest(const Vec3d& direction, double up_to = std::numeric_limits<double>::infinity()) const;

 private:
  std::vector<RevolvedProfile::Point> outline_;  // of a tool of revolution
  std::vector<Vec3d> points_;                    // of any other tool
};

/// Tilts a tool that stands on a surface (toolOver()) about its contact point. An upright tilt changes nothing.
void tiltTool(ToolOverSurface& over, const Tilt& tilt, const TouchPoints& touch);

/// The same for a held axis (unit, out of the tissue), as of a path of insertion. On a wall steeper than 60 degrees to
/// it the tool's end touches with its side, and the tool goes in along the normal.
/// @return  false: an undercut by more than 35 degrees. The tool stays upright.
bool holdTool(ToolOverSurface& over, const Vec3d& axis, const TouchPoints& touch);

}  // namespace kerf
