// Shader programs, and errors for failed OpenGL calls, for the renderers of this folder.
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

/// A byte offset in a buffer, in the form OpenGL takes.
inline const void* bufferOffset(std::size_t bytes) { return static_cast<const char*>(nullptr) + bytes; }

/// One program. Its owner deletes `id`. Setting a uniform that the program does not use has no effect.
class GlProgram {
 public:
  GLuint id = 0;

  /// The texts of each stage are joined in order.
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
