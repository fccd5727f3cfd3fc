#include "ui/window/glfw_error.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <utility>

namespace kerf {

Error noWindow(std::string found) {
  return {.code = Error::Code::kUnsupported,
          .place = "window",
          .found = std::move(found),
          .expected = "a display with OpenGL 3.3",
          .hint = "kerf-sim --screenshot OUT.png or --script FILE, which need no display, or xvfb-run kerf-sim"};
}

std::string lastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

}  // namespace kerf
