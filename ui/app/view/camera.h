// The camera of the window and of pictures. Default: parallel projection, one scale everywhere. With a field of view:
// perspective, and mm are true in the focal plane through the target; nearer things are larger.
//
// World frame: right-handed, mm, the frame of the scan. Upright frame: the world frame turned about its axes so that +z
// is up, because a scan may have any side up. Azimuth and elevation place the camera about the target, in this frame:
//   azimuth 0 looks along +y (the front), growing counter-clockwise seen from +z: 90 deg stands at +x (the right side).
//   elevation 90 deg looks down on the occlusal side (+z), with +y up in the picture.
// View frame: x right, y up, z towards the viewer, origin at the target.
#pragma once

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct Camera {
  double azimuth = 0;                                     ///< rad
  double elevation = 0;                                   ///< rad, in [-pi/2, pi/2]
  Vec3d target = Vec3d::Zero();                           ///< mm, shown at the centre of the picture
  double half_height = 10;                                ///< mm from the target to the upper edge, > 0: the zoom
  Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();  ///< world direction -> upright direction: uprightFrame()
  double field_of_view = 0;                               ///< rad from the lower to the upper edge; 0: parallel
  double roll = 0;                                        ///< rad, clockwise rotation of the picture

  /// Fraction of the distance from eye to target. Nearer things are neither shown nor pickable.
  static constexpr double kNearest = 0.02;
  static constexpr double kLeastField = 5, kMostField = 90;  ///< deg

  Vec3d right() const;      ///< unit, world frame
  Vec3d up() const;         ///< unit, world frame
  Vec3d backwards() const;  ///< unit, world frame, from the target to the viewer
  /// Rows right, up, backwards: world direction -> view direction.
  Eigen::Matrix3d rotation() const;
  double mmPerPixel(int height) const { return 2 * half_height / height; }  ///< at the target

  bool isPerspective() const { return field_of_view > 0; }
  /// mm from the target; only in perspective.
  double eyeDistance() const { return half_height / std::tan(0.5 * field_of_view); }
  /// Pixel size at a point relative to the pixel size at the target: 1 in parallel projection, at least kNearest.
  double shrinkAt(const Vec3d& point) const;
  double mmPerPixelAt(const Vec3d& point, int height) const { return shrinkAt(point) * mmPerPixel(height); }
  /// Unit, world frame: from a point along its line of sight to the viewer.
  Vec3d towardsViewer(const Vec3d& point) const;
};

struct NamedView {
  std::string_view name;
  double azimuth_deg, elevation_deg;
};
/// front, back, left, right, top (also: occlusal), bottom, iso.
const std::vector<NamedView>& namedViews();

/// A camera with the direction of a named view or of "AZ,EL" in degrees ("35,20"; EL in [-90, 90]), with default target
/// and zoom. Other text is an error that lists the names.
Expected<Camera> cameraFromView(std::string_view view);

/// Rotation about coordinate axes that brings the axis nearest to `up` to +z. For +z: none; for +-x it keeps +y, else
/// +x.   @pre  up is finite, not 0.
Eigen::Matrix3d uprightFrame(const Vec3d& up);
/// Direction of "+x", "-x", "y" ...; other text is an error that lists the names.
Expected<Vec3d> axisFromName(std::string_view name);
/// Name of the coordinate axis nearest to a direction: "+x" ...
std::string nameOfAxis(const Vec3d& direction);
/// Puts the viewer in this direction (world, any length but 0) and keeps the upright frame. Seen from straight above,
/// +y of that frame is up in the picture.
void lookFrom(Camera& camera, const Vec3d& direction);
/// The same, exact near the poles too; a roll makes `up` vertical in the picture.   @pre  not parallel.
void lookFrom(Camera& camera, const Vec3d& direction, const Vec3d& up);

/// Centres the mesh and zooms so that it just fits into width x height pixels, `margin` (fraction) free on each side.
/// A mesh without vertices, or with all in one point, gets a 10 mm field about it. O(vertices).
void fitTo(Camera& camera, const Mesh& mesh, int width, int height, double margin = 0.07);

/// Mouse moves, in pixels (y downwards) of a window `height` pixels high.
void orbit(Camera& camera, double dx, double dy);            ///< 0.5 deg per pixel; elevation stops at the poles
void pan(Camera& camera, double dx, double dy, int height);  ///< a focal point under the cursor stays under it
void zoomBy(Camera& camera, double factor);                  ///< factor > 1 makes things larger
/// Perspective or, with 0, parallel. Things at the focus keep their size.   @param angle  rad
void setFieldOfView(Camera& camera, double angle);
/// In perspective: moves the target along the view to the depth of a point; eye and picture stay. Zooming in then
/// brings the eye near that surface, never through it. In parallel projection: no effect.
void focusOn(Camera& camera, const Vec3d& point);

/// Length of a scale bar: the largest 1, 2 or 5 times a power of ten, in mm, not over a quarter of the width.
double scaleBarLength(double mm_per_pixel, int width);

}  // namespace kerf
