// Errors when no window can open, with a remedy.
#pragma once

#include <string>

#include "geometry/base/error.h"

namespace kerf {

/// kUnsupported, with alternatives.   @param found  the cause.
Error noWindow(std::string found);
/// The display lacks OpenGL 3.3: names its version, and a way to draw without it. Call after glfwInit(), if a window
/// could not be created.
Error noOpenGl();
/// GLFW's last error. On the thread that uses GLFW.
std::string lastGlfwError();

}  // namespace kerf
