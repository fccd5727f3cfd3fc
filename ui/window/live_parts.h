// What the parts of a live picture share: how a frame is seen, its light, corners that are drawn flat.
#pragma once

#include <epoxy/gl.h>

#include <array>

#include "geometry/base/types.h"
#include "ui/window/gl_program.h"

namespace kerf::internal {

/// How a frame is seen.
struct FrameView {
  Eigen::Matrix3d rotation;  ///< world -> view
  Vec3d target;
  Vec3d half_extent;  ///< of what is shown, mm; z: depth
  double mm_per_pixel = 1;
  int width = 1, height = 1;
  Eigen::Matrix4d to_clip;  ///< world -> clip
  double slope = 0;         ///< per mm towards the viewer, things are so much larger; 0: parallel projection

  Vec3d toView(const Vec3d& p) const { return rotation * (p - target); }
  /// mm a pixel shows at a depth of the view frame, as a part of that at the target. Not positive: behind the eye.
  double shrinkAt(double z) const { return 1 - slope * z; }
  /// The line of sight through a place of the picture, -1 to 1: a point of it, and its direction, as long as it is from
  /// the eye to the target or in parallel projection 1. View frame.
  std::array<Vec3d, 2> sightThrough(double x, double y) const {
    const Vec3d at_target(x * half_extent[0], y * half_extent[1], 0);
    if (slope == 0) return {at_target, Vec3d(0, 0, -1)};
    const Vec3d eye(0, 0, 1 / slope);
    return {eye, at_target - eye};
  }
  /// How much a plane of this normal faces the viewer, cosine; both view frame.
  double facing(const Vec3d& point, const Vec3d& normal) const {
    const Vec3d to_eye = Vec3d(0, 0, 1) - slope * point;
    return normal.dot(to_eye) / (normal.norm() * to_eye.norm());
  }
  /// Whether a box about `middle` reaches out of what is shown, and whether it is all outside; view frame.
  struct Visibility {
    bool is_whole = true, is_outside = false;
  };
  Visibility visibilityOf(const Vec3d& middle, const Vec3d& half) const;
  /// Object frame, mm -> (x w, y w, w): x, y are pixels, the middle of the first at 0; w is 1 at the target.
  Eigen::Matrix<double, 3, 4> toPixels(const Rigid3& T_world_object) const;
};

/// One corner of what is drawn flat, in one colour.
struct FlatCorner {
  std::array<float, 2> position;  ///< of the picture, -1 to 1
  std::array<float, 4> color;     ///< sRGB, alpha
};
static_assert(sizeof(FlatCorner) == 24);
/// Tells a vertex array what is in a buffer of FlatCorners.
void describeFlat(GLuint array, GLuint buffer);

/// The lights that all solid things stand in: uniforms of kLight (live_shaders.h).
void setLights(const GlProgram& program);

Eigen::Matrix4d matrixOf(const Rigid3& pose);

}  // namespace kerf::internal
