// Why there is no window, in words that help.
#pragma once

#include <string>

#include "geometry/base/error.h"

namespace kerf {

/// kUnsupported, with what else can be done.   @param found  what went wrong.
Error noWindow(std::string found);
/// What GLFW said last; the thread that uses GLFW.
std::string lastGlfwError();

}  // namespace kerf
