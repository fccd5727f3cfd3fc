// A framebuffer to draw a picture into and read back, for the renderers of this folder.
#pragma once

#include <epoxy/gl.h>

#include "ui/window/gl/image.h"

namespace kerf::internal {

/// RGBA with 8 bits a channel, a depth buffer. Needs the context current, the destructor too.
class GlTarget {
 public:
  GlTarget(int width, int height);
  ~GlTarget();
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  GLuint id() const { return framebuffer_; }
  /// The drawn picture, rows from the top.
  Image read() const;

 private:
  int width_, height_;
  GLuint framebuffer_ = 0, color_ = 0, depth_ = 0;
};

}  // namespace kerf::internal
