#include "ui/window/gl/gl_program.h"

namespace kerf::internal {
namespace {

Expected<GLuint> compiled(GLenum kind, std::initializer_list<const char*> sources) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, static_cast<GLsizei>(sources.size()), sources.begin(), nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok) return shader;
  char log[1024] = "";
  glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  glDeleteShader(shader);
  return fail(glFailure("shader", log));
}

}  // namespace

Error glFailure(std::string place, std::string found) {
  return {.code = Error::Code::kUnsupported,
          .file = {},
          .place = std::move(place),
          .found = std::move(found),
          .expected = "OpenGL 3.3",
          .hint = "update the graphics driver, or set LIBGL_ALWAYS_SOFTWARE=1"};
}

Expected<void> GlProgram::build(std::initializer_list<const char*> vertex,
                                std::initializer_list<const char*> fragment) {
  KERF_TRY(v, compiled(GL_VERTEX_SHADER, vertex));
  KERF_TRY(f, compiled(GL_FRAGMENT_SHADER, fragment));
  id = glCreateProgram();
  glAttachShader(id, v);
  glAttachShader(id, f);
  glLinkProgram(id);
  glDeleteShader(v);
  glDeleteShader(f);
  GLint ok = 0;
  glGetProgramiv(id, GL_LINK_STATUS, &ok);
  if (ok) return {};
  char log[1024] = "";
  glGetProgramInfoLog(id, sizeof log, nullptr, log);
  return fail(glFailure("shader program", log));
}

}  // namespace kerf::internal
