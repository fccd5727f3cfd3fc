// Why there is no window, in words that help.
#pragma once

#include <string>

#include "geometry/base/error.h"

namespace kerf {

/// kUnsupported, with what else can be done.   @param found  what went wrong.
Error noWindow(std::string found);
/// The display is there, but has no OpenGL 3.3: what it has instead, and what draws without it. After glfwInit(), when
/// a window could not be created.
Error noOpenGl();
/// What GLFW said last; the thread that uses GLFW.
std::string lastGlfwError();

}  // namespace kerf
