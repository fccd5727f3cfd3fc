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

  Vec3d toView(const Vec3d& p) const { return rotation * (p - target); }
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
