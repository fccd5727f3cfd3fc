// The face of a section through one object, as a texture: its materials in the plane.
#pragma once

#include <epoxy/gl.h>

#include "sim/live/tissue_section.h"
#include "ui/window/draw/live_parts.h"
#include "ui/window/gl/gl_program.h"

namespace kerf::internal {

/// A pixel's place in the plane does not depend on the surface behind it.
/// Needs its OpenGL context current in every call, the destructor included.
class LiveSection {
 public:
  LiveSection() = default;
  ~LiveSection();
  LiveSection(const LiveSection&) = delete;
  LiveSection& operator=(const LiveSection&) = delete;

  void set(const TissueSection& section);
  /// Texture unit 1.
  void bind() const;
  /// Uniforms of a program with SECTION.
  /// @param plane  world frame: the plane of the picture from set(), in the frame of the object at `pose`.
  void setUniforms(const GlProgram& program, const FrameView& view, const Plane& plane, const Rigid3& pose) const;

 private:
  TissueSection section_;  // without its colours
  GLuint texture_ = 0;
};

}  // namespace kerf::internal
