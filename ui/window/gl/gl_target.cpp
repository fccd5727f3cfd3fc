#include "ui/window/gl/gl_target.h"

#include <algorithm>

namespace kerf::internal {

GlTarget::GlTarget(int width, int height) : width_(width), height_(height) {
  glGenRenderbuffers(1, &color_);
  glGenRenderbuffers(1, &depth_);
  glGenFramebuffers(1, &framebuffer_);
  glBindRenderbuffer(GL_RENDERBUFFER, color_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  glBindRenderbuffer(GL_RENDERBUFFER, depth_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
}

GlTarget::~GlTarget() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteRenderbuffers(1, &color_);
  glDeleteRenderbuffers(1, &depth_);
}

Image GlTarget::read() const {
  const std::size_t row = 4 * static_cast<std::size_t>(width_), rows = static_cast<std::size_t>(height_);
  std::vector<std::uint8_t> upwards(row * rows);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, upwards.data());

  Image image{width_, height_, std::vector<std::uint8_t>(upwards.size())};
  for (std::size_t y = 0; y < rows; ++y)
    std::copy_n(upwards.data() + (rows - 1 - y) * row, row, image.rgba.data() + y * row);
  return image;
}

}  // namespace kerf::internal
