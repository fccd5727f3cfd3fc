#include "ui/window/gl/glfw_error.h"

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <utility>

namespace kerf {

Error noWindow(std::string found) {
  return {.code = Error::Code::kUnsupported,
          .place = "window",
          .found = std::move(found),
          .expected = "a display with OpenGL 3.3",
          .hint = "use kerf-sim --screenshot OUT.png or --script FILE (no display needed), or xvfb-run kerf-sim"};
}

// A hidden window without a version request gets the newest version.
Error noOpenGl() {
  const std::string reason = lastGlfwError();
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  GLFWwindow* const hidden = glfwCreateWindow(16, 16, "Kerf", nullptr, nullptr);
  if (!hidden) return noWindow("cannot open a window: " + reason);

  glfwMakeContextCurrent(hidden);
  const auto* const version = reinterpret_cast<const char*>(glGetString(GL_VERSION));
  const auto* const driver = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  std::string found = "this display has OpenGL ";
  found += version ? version : "with an unknown version";
  if (driver) found += std::string(" (") + driver + ")";
  glfwDestroyWindow(hidden);
  return {.code = Error::Code::kUnsupported,
          .place = "window",
          .found = std::move(found) + ", too old for Kerf",
          .expected = "OpenGL 3.3 or newer",
          .hint =
              "update the graphics driver, or draw in software with LIBGL_ALWAYS_SOFTWARE=1 kerf-sim (Debian: "
              "libgl1-mesa-dri)"};
}

std::string lastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

}  // namespace kerf
