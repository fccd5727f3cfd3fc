// A tilted tool: leant away from the normal of the surface, about the point that it touches.
//
// The lean is towards a direction of the world, as a hand holds a handpiece: it stays when the camera turns. What is
// asked for by a mouse or in degrees is meant in the view: azimuth 0 leans the shank to the right of the picture, 90 to
// its upper edge.
//
// Depth and force of a stroke go by the normal all the same (sim/hand/mouse_hand.h): what of the tool is deepest stops
// at the depth below the surface as loaded. From where it touched, the tool goes in along its own axis.
#pragma once

#include <numbers>
#include <vector>

#include "geometry/tool/tool.h"
#include "ui/app/camera.h"
#include "ui/app/stroke.h"

namespace kerf {

struct Tilt {
  static constexpr double kMost = 75 * std::numbers::pi / 180;  ///< rad

  double angle = 0;                ///< between the tool's axis and the normal, rad, 0 to kMost
  Vec3d towards = Vec3d::UnitX();  ///< unit, world: the shank leans that way
  bool isUpright() const { return !(angle > 0); }
};

/// @param angle  rad, cut to 0 .. kMost.   @param azimuth  in the view, rad.
Tilt tiltInView(const Camera& camera, double angle, double azimuth);
/// Where the lean points in the view, rad, -pi to pi; 0 when it points at the viewer or away.
double azimuthInView(const Camera& camera, const Tilt& tilt);
/// The pointer has moved by so many pixels (y downwards): half a degree each, towards where it went.
Tilt tiltedBy(const Tilt& tilt, const Camera& camera, double dx, double dy);
/// The tool's way out of tissue with that normal: unit. Tilted towards the normal itself it leans any way.
Vec3d tiltedAxis(const Tilt& tilt, const Vec3d& normal);

/// Where a tool first touches a flat surface, however it is held: the farthest point of what cuts.
class TouchPoints {
 public:
  /// Of a tool of revolution its outline, within 0.05 um; of a mesh its vertices; of a blade the box about its teeth
  /// and their stroke.
  explicit TouchPoints(const Tool& tool);
  /// @param direction  unit, tool frame: into the surface.   @return  tool frame, mm.
  Vec3d farthest(const Vec3d& direction) const;

 private:
  std::vector<RevolvedProfile::Point> outline_;  // of what revolves
  std::vector<Vec3d> points_;                    // of what does not
};

/// Tilts a tool that stands on a surface (toolOver()) about the point there. An upright one is left as it is.
void tiltTool(ToolOverSurface& over, const Tilt& tilt, const TouchPoints& touch);

}  // namespace kerf
