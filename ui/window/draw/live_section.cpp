#include "ui/window/draw/live_section.h"

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
  const Vec3d middle = view.toView(plane.point);
  const bool is_shown = section_.width > 0 && view.facing(middle, n) > kEdgeOn;
  program.set("section_tissues", 1);
  program.set("has_tissues", is_shown ? 1 : 0);
  if (!is_shown) return;

  // Place where a pixel's line of sight meets the plane: as a share of the picture's width and height, times a weight.
  // All three are affine in the pixel; in parallel projection the weight is constant.
  const Rigid3 to_object = pose.inverse();
  const auto placeOf = [&](double x, double y) -> Vec3d {
    const auto [from, way] = view.sightThrough(x, y);
    const double weight = n.dot(way);
    const Vec3d begin = to_object * (view.rotation.transpose() * from + view.target) - section_.origin;
    const Vec3d at = weight * begin + n.dot(middle - from) * (to_object.rotation * (view.rotation.transpose() * way));
    return {(at.dot(section_.u) / section_.u.squaredNorm() + 0.5 * weight) / section_.width,
            (at.dot(section_.v) / section_.v.squaredNorm() + 0.5 * weight) / section_.height, weight};
  };
  const Vec3d first = placeOf(-1, -1);
  const Vec3d along = (placeOf(1, -1) - first) / view.width;
  const Vec3d upwards = (placeOf(-1, 1) - first) / view.height;
  const auto set = [&](const char* name, int row) {
    program.set(name, Vec3f(Vec3d(along[row], upwards[row], first[row]).cast<float>()));
  };
  set("section_across", 0);
  set("section_up", 1);
  set("section_weight", 2);
}

}  // namespace kerf::internal
