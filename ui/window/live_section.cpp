#include "ui/window/live_section.h"

#include <array>

namespace kerf::internal {

LiveSection::~LiveSection() { glDeleteTextures(1, &texture_); }

void LiveSection::set(const TissueSection& section) {
  section_ = section;
  section_.colours.clear();
  if (section.isEmpty()) section_.width = section_.height = 0;
  if (section_.width == 0) return;

  if (texture_ == 0) glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, section.width, section.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               section.colours.data());
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, axis, GL_CLAMP_TO_EDGE);
}

void LiveSection::bind() const {
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glActiveTexture(GL_TEXTURE0);
}

void LiveSection::setUniforms(const GlProgram& program, const FrameView& view, const Plane& plane,
                              const Rigid3& pose) const {
  constexpr double kEdgeOn = 1e-3;
  const Vec3d n = view.rotation * plane.normal;
  const bool is_shown = section_.width > 0 && n[2] > kEdgeOn * n.norm();
  program.set("section_tissues", 1);
  program.set("has_tissues", is_shown ? 1 : 0);
  if (!is_shown) return;

  // Where a pixel's line of sight meets the plane: as a share of the picture's width and height.
  const Vec3d middle = view.toView(plane.point);
  const Rigid3 to_object = pose.inverse();
  const auto placeOf = [&](double x, double y) {
    Vec3d p((2 * x / view.width - 1) * view.half_extent[0], (2 * y / view.height - 1) * view.half_extent[1], 0);
    p[2] = (n.dot(middle) - n[0] * p[0] - n[1] * p[1]) / n[2];
    const Vec3d from = to_object * (view.rotation.transpose() * p + view.target) - section_.origin;
    return Eigen::Vector2d((from.dot(section_.u) / section_.u.squaredNorm() + 0.5) / section_.width,
                           (from.dot(section_.v) / section_.v.squaredNorm() + 0.5) / section_.height);
  };
  const Eigen::Vector2d first = placeOf(0, 0);
  const Eigen::Vector2d along = (placeOf(view.width, 0) - first) / view.width;
  const Eigen::Vector2d upwards = (placeOf(0, view.height) - first) / view.height;
  program.set("section_across", Vec3f(Vec3d(along[0], upwards[0], first[0]).cast<float>()));
  program.set("section_up", Vec3f(Vec3d(along[1], upwards[1], first[1]).cast<float>()));
}

}  // namespace kerf::internal
