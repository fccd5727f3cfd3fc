// kerf-sim --screenshot: a picture of a mesh, a case or a run, without a window.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "geometry/base/error.h"
#include "ui/app/view/camera.h"
#include "ui/app/view/scene.h"

namespace kerf {

struct ScreenshotOptions {
  std::filesystem::path file;   ///< a PNG; replaced if it exists
  std::filesystem::path scene;  ///< a mesh, a case or a run
  std::string unit;             ///< of a mesh; empty: from the file, or by its size
  Camera camera{};              ///< its direction; the scene is fitted into the picture
  int width = 1200, height = 900;
  double zoom = 1;                        ///< 1 fits the object
  std::optional<Vec3d> look_at{};         ///< middle of the picture, mm; none: of the mesh
  std::optional<SectionPlane> section{};  ///< none: all of it
  std::optional<Vec3d> up{};              ///< none: from the scan
  bool has_shadow = true, is_transparent = false, has_scale_bar = true, has_grid = false;
  bool uses_gpu = false;  ///< the bytes of the picture then depend on the graphics card
  bool tells = false;     ///< prints the OpenGL driver on standard error
};

/// Errors: those of reading the scene; kUnsupported without OpenGL 3.3; kWriteFailed.
Expected<void> writeScreenshot(const ScreenshotOptions& options);

}  // namespace kerf
