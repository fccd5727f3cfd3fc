// The window of kerf-sim: one mesh, a mouse camera, a panel.
#pragma once

#include "geometry/base/error.h"
#include "ui/app/camera.h"
#include "ui/app/scene.h"

namespace kerf {

struct WindowOptions {
  int width = 1280, height = 800;
  int frames = 0;  ///< close after this many frames; 0 stays open until the user closes it
};

/// Shows the scene until the window is closed. Left button orbits, middle or right (or shift + left) pans, wheel zooms
/// about the cursor, keys 1-7 take the named views, F fits, Esc closes.
/// Main thread only. Needs a display: without one an error that says what to do instead.
/// @return frames drawn.
Expected<int> runWindow(const Scene& scene, Camera camera, const WindowOptions& options);

}  // namespace kerf
