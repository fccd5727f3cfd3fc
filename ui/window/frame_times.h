// What a frame costs the processor: the live renderer and the one for pictures, in turn, on the same mesh.
#pragma once

#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"
#include "ui/app/camera.h"

namespace kerf {

struct FrameTimes {
  std::size_t triangles = 0;
  std::string driver;           ///< what drew
  std::vector<double> live;     ///< ms of processor time of all threads, one per frame
  std::vector<double> picture;  ///< the same of Renderer as the window has used it, a fifth as many frames

  /// Two lines for people and programs: "live p50 31.2 p95 34.0 ms", "picture p50 201.0 p95 215.0 ms".
  std::string summary() const;
};

/// Draws the mesh from views 1 degree apart, with a tool upon its middle, without a display. The first frame of each,
/// in which the driver compiles, is not counted.
/// Processor time, not time on the clock: other programs disturb it by a fifth, not by a multiple.
/// @param frames  of the live renderer, at least 5.
Expected<FrameTimes> timeFrames(const Mesh& mesh, Camera camera, int width, int height, int frames);

}  // namespace kerf
