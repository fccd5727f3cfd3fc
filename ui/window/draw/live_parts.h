// Shared by the parts of a live picture: view of a frame, lights, flat corners.
#pragma once

#include <epoxy/gl.h>

#include <array>

#include "geometry/base/types.h"
#include "ui/window/gl/gl_program.h"

namespace kerf::internal {

/// View of a frame.
struct FrameView {
  Eigen::Matrix3d rotation;  ///< world -> view
  Vec3d target;
  Vec3d half_extent;  ///< of the view, mm; z: depth
  double mm_per_pixel = 1;
  int width = 1, height = 1;
  Eigen::Matrix4d to_clip;  ///< world -> clip
  double slope = 0;         ///< relative growth of size per mm towards the viewer; 0: parallel projection

  Vec3d toView(const Vec3d& p) const { return rotation * (p - target); }
  /// Size of a pixel in mm at a depth of the view frame, relative to the target. Not positive: behind the eye.
  double shrinkAt(double z) const { return 1 - slope * z; }
  /// Line of sight through a place of the picture, -1 to 1: a point and a direction. Its length is the distance from
  /// eye to target, or 1 in parallel projection. View frame.
  std::array<Vec3d, 2> sightThrough(double x, double y) const {
    const Vec3d at_target(x * half_extent[0], y * half_extent[1], 0);
    if (slope == 0) return {at_target, Vec3d(0, 0, -1)};
    const Vec3d eye(0, 0, 1 / slope);
    return {eye, at_target - eye};
  }
  /// Cosine between the plane's normal and the direction to the viewer; both view frame.
  double facing(const Vec3d& point, const Vec3d& normal) const {
    const Vec3d to_eye = Vec3d(0, 0, 1) - slope * point;
    return normal.dot(to_eye) / (normal.norm() * to_eye.norm());
  }
  /// Whether a box about `middle` crosses the border of the view, and whether it is fully outside; view frame.
  struct Visibility {
    bool is_whole = true, is_outside = false;
  };
  Visibility visibilityOf(const Vec3d& middle, const Vec3d& half) const;
  /// Object frame, mm -> (x w, y w, w): x, y are pixels, the middle of the first at 0; w is 1 at the target.
  Eigen::Matrix<double, 3, 4> toPixels(const Rigid3& T_world_object) const;
};

/// One corner of a flat primitive, in one colour.
struct FlatCorner {
  std::array<float, 2> position;  ///< of the picture, -1 to 1
  std::array<float, 4> color;     ///< sRGB, alpha
};
static_assert(sizeof(FlatCorner) == 24);
/// Describes a buffer of FlatCorners to a vertex array.
void describeFlat(GLuint array, GLuint buffer);

/// Lights of all solid objects: uniforms of kLight (live_shaders.h).
void setLights(const GlProgram& program);

Eigen::Matrix4d matrixOf(const Rigid3& pose);

}  // namespace kerf::internal
