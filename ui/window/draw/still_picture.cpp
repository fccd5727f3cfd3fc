#include "ui/window/draw/still_picture.h"

#include <fmt/format.h>

#include <array>

#include "ui/window/draw/live_shaders.h"

namespace kerf {
namespace {

using internal::glFailure;

// Offsets within a pixel, right and up: the corners of a turned square, so that no two share a row or a column.
constexpr std::array<std::array<double, 2>, StillPicture::kSamples> kAside = {
    {{-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}}};

constexpr const char* kSquare = R"(
uniform sampler2D points;
out vec4 result;
void main() {
  vec3 c = texelFetch(points, ivec2(gl_FragCoord.xy), 0).rgb;
  result = vec4(c * c, 1.0);
}
)";
constexpr const char* kRoot = R"(
uniform sampler2D points;
out vec4 result;
void main() { result = vec4(sqrt(texelFetch(points, ivec2(gl_FragCoord.xy), 0).rgb), 1.0); }
)";

bool isSamePose(const std::optional<Rigid3>& a, const std::optional<Rigid3>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || (a->translation == b->translation && a->rotation.coeffs() == b->rotation.coeffs());
}

bool isSamePlane(const std::optional<Plane>& a, const std::optional<Plane>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || (a->normal == b->normal && a->point == b->point);
}

bool isSameCamera(const Camera& a, const Camera& b) {
  return a.azimuth == b.azimuth && a.elevation == b.elevation && a.target == b.target &&
         a.half_height == b.half_height && a.upright == b.upright && a.field_of_view == b.field_of_view &&
         a.roll == b.roll;
}

}  // namespace

StillPicture::~StillPicture() {
  if (empty_array_ == 0) return;
  glDeleteVertexArrays(1, &empty_array_);
  for (const GLuint target : {drawn_target_, mean_target_}) glDeleteFramebuffers(1, &target);
  for (const GLuint texture : {drawn_color_, mean_color_}) glDeleteTextures(1, &texture);
  glDeleteRenderbuffers(1, &drawn_depth_);
  for (const internal::GlProgram* program : {&square_, &root_}) glDeleteProgram(program->id);
}

bool PictureContent::isSame(const PictureContent& other) const {
  return version == other.version && width == other.width && height == other.height &&
         isSameCamera(camera, other.camera) && isSamePose(frame.T_world_tool, other.frame.T_world_tool) &&
         frame.is_ghost == other.frame.is_ghost && isSamePlane(frame.section, other.frame.section) &&
         frame.plan == other.frame.plan;
}

Expected<void> StillPicture::prepare(int width, int height) {
  if (empty_array_ == 0) {
    const char* const version = "#version 330 core\n";
    KERF_CHECK(square_.build({version, live_shaders::kReduceVertex}, {version, kSquare}));
    KERF_CHECK(root_.build({version, live_shaders::kReduceVertex}, {version, kRoot}));
    glGenVertexArrays(1, &empty_array_);
    glGenFramebuffers(1, &drawn_target_);
    glGenFramebuffers(1, &mean_target_);
    glGenTextures(1, &drawn_color_);
    glGenTextures(1, &mean_color_);
    glGenRenderbuffers(1, &drawn_depth_);
  }
  if (width == width_ && height == height_) return {};

  width_ = height_ = 0;
  const auto attach = [&](GLuint target, GLuint texture, GLint format, GLenum type) {
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, GL_RGBA, type, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  };
  attach(mean_target_, mean_color_, GL_RGBA16F, GL_HALF_FLOAT);
  const bool has_mean = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  attach(drawn_target_, drawn_color_, GL_RGBA8, GL_UNSIGNED_BYTE);
  glBindRenderbuffer(GL_RENDERBUFFER, drawn_depth_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, drawn_depth_);
  if (!has_mean || glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    return fail(glFailure("drawing", fmt::format("the driver refuses a framebuffer of {} x {}", width, height)));
  width_ = width;
  height_ = height;
  return {};
}

// Adds the n-th sample to the mean.
void StillPicture::add(int sample) {
  glBindFramebuffer(GL_FRAMEBUFFER, mean_target_);
  glViewport(0, 0, width_, height_);
  if (sample > 0) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
    glBlendColor(0, 0, 0, 1.0f / static_cast<float>(sample + 1));
  }
  square_.use();
  square_.set("points", 0);
  glBindTexture(GL_TEXTURE_2D, drawn_color_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
}

void StillPicture::show(GLuint target, int width, int height) {
  glBindFramebuffer(GL_FRAMEBUFFER, target);
  glViewport(0, 0, width, height);
  root_.use();
  root_.set("points", 0);
  glBindTexture(GL_TEXTURE_2D, mean_color_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Expected<void> StillPicture::draw(LiveRenderer& renderer, const Camera& camera, int width, int height,
                                  const LiveFrame& frame) {
  GLint bound = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
  const auto target = static_cast<GLuint>(bound);

  PictureContent now{renderer.version(), camera, width, height, frame};
  const bool can_refine = width > 0 && height > 0 && frame.plan.isEmpty();
  if (!can_refine || !subject_ || !subject_->isSame(now)) {
    samples_ = 0;
    subject_.reset();
    if (can_refine) subject_ = std::move(now);
    return renderer.draw(camera, width, height, frame);
  }

  KERF_CHECK(prepare(width, height));
  if (samples_ < kSamples) {
    const auto& aside = kAside[static_cast<std::size_t>(samples_)];
    Camera moved = camera;
    moved.target += camera.mmPerPixel(height) * (aside[0] * camera.right() + aside[1] * camera.up());
    glBindFramebuffer(GL_FRAMEBUFFER, drawn_target_);
    KERF_CHECK(renderer.draw(moved, width, height, frame));
    glActiveTexture(GL_TEXTURE0);
    glBindVertexArray(empty_array_);
    add(samples_++);
  }
  glActiveTexture(GL_TEXTURE0);
  glBindVertexArray(empty_array_);
  show(target, width, height);
  glBindVertexArray(0);
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    return fail(glFailure("drawing", fmt::format("OpenGL error 0x{:x}", error)));
  return {};
}

}  // namespace kerf
