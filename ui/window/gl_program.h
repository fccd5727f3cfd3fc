// Shader programs, and the error that says what OpenGL did not do: for the renderers of this folder.
#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <initializer_list>
#include <string>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf::internal {

/// "PLACE: FOUND; expected OpenGL 3.3. Try: ..."
Error glFailure(std::string place, std::string found);

/// A place in a buffer, as OpenGL wants it.
inline const void* bufferOffset(std::size_t bytes) { return static_cast<const char*>(nullptr) + bytes; }

/// One program. Its owner deletes `id`. A uniform that the program does not use may be set: nothing happens.
class GlProgram {
 public:
  GLuint id = 0;

  /// Each stage is its texts one after the other.
  Expected<void> build(std::initializer_list<const char*> vertex, std::initializer_list<const char*> fragment);

  void use() const { glUseProgram(id); }
  GLint at(const char* name) const { return glGetUniformLocation(id, name); }
  void set(const char* name, int v) const { glUniform1i(at(name), v); }
  void set(const char* name, double v) const { glUniform1f(at(name), static_cast<float>(v)); }
  void set(const char* name, const Vec3f& v) const { glUniform3fv(at(name), 1, v.data()); }
  void set(const char* name, const Eigen::Vector2f& v) const { glUniform2fv(at(name), 1, v.data()); }
  void set(const char* name, const Eigen::Vector4f& v) const { glUniform4fv(at(name), 1, v.data()); }
  void set(const char* name, const Eigen::Matrix3f& m) const { glUniformMatrix3fv(at(name), 1, GL_FALSE, m.data()); }
  void set(const char* name, const Eigen::Matrix4f& m) const { glUniformMatrix4fv(at(name), 1, GL_FALSE, m.data()); }
};

}  // namespace kerf::internal
