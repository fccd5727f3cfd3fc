// An OpenGL 3.3 core context without a window, for pictures on machines without display and GPU.
#pragma once

#include <memory>
#include <string>

#include "geometry/base/error.h"

namespace kerf {

/// Owns the context and keeps it current on the thread that made it; that thread must destroy it.
class OffscreenContext {
 public:
  /// Tries, in this order: EGL without a surface (Mesa), EGL on each device, EGL on the default display, a hidden GLFW
  /// window if a display is set. `software` selects Mesa's software renderer (llvmpipe) through the environment
  /// variable LIBGL_ALWAYS_SOFTWARE, unless that is already set: the same picture on every machine and GPU.
  /// @return an error that lists each attempt and the Debian packages to install, if none gives OpenGL 3.3.
  static Expected<std::unique_ptr<OffscreenContext>> create(bool software = true);
  virtual ~OffscreenContext() = default;

  /// "EGL without a surface: llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 ..." for -v and bug reports.
  std::string description;

 protected:
  OffscreenContext() = default;
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;
};

}  // namespace kerf
