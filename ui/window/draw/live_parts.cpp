#include "ui/window/draw/live_parts.h"

#include <cmath>
#include <cstddef>

namespace kerf::internal {
namespace {

const Vec3f kKeyLight = Vec3f(-0.46f, 0.62f, 0.63f).normalized();
const Vec3f kFillLight = Vec3f(0.85f, 0.05f, 0.5f).normalized();

}  // namespace

void describeFlat(GLuint array, GLuint buffer) {
  glBindVertexArray(array);
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, sizeof(FlatCorner), bufferOffset(offsetof(FlatCorner, position)));
  glVertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(FlatCorner), bufferOffset(offsetof(FlatCorner, color)));
  glEnableVertexAttribArray(0);
  glEnableVertexAttribArray(1);
}

void setLights(const GlProgram& program) {
  program.set("key_light", kKeyLight);
  program.set("key_half", Vec3f((kKeyLight + Vec3f::UnitZ()).normalized()));
  program.set("fill_light", kFillLight);
}

// A box is wide enough for its farthest side to show, and narrow enough for its nearest one.
FrameView::Visibility FrameView::visibilityOf(const Vec3d& middle, const Vec3d& half) const {
  const double farthest = shrinkAt(middle[2] - half[2]), nearest = shrinkAt(middle[2] + half[2]);
  Visibility out{.is_whole = nearest > 0, .is_outside = farthest <= 0};
  for (int axis = 0; axis < 2; ++axis) {
    out.is_outside |= std::abs(middle[axis]) - half[axis] > farthest * half_extent[axis];
    out.is_whole &= std::abs(middle[axis]) + half[axis] <= nearest * half_extent[axis];
  }
  return out;
}

Eigen::Matrix<double, 3, 4> FrameView::toPixels(const Rigid3& T_world_object) const {
  const Eigen::Matrix4d clip = to_clip * matrixOf(T_world_object);
  Eigen::Matrix<double, 3, 4> out;
  out.row(0) = 0.5 * width * (clip.row(0) + clip.row(3)) - 0.5 * clip.row(3);
  out.row(1) = 0.5 * height * (clip.row(1) + clip.row(3)) - 0.5 * clip.row(3);
  out.row(2) = clip.row(3);
  return out;
}

Eigen::Matrix4d matrixOf(const Rigid3& pose) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  m.topRightCorner<3, 1>() = pose.translation;
  return m;
}

}  // namespace kerf::internal
