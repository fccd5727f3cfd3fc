// Draws one mesh with studio light: the same code for the window and for pictures. OpenGL 3.3 core.
//
// Four passes: surface (colour, normal, depth), occlusion (crevice darkening and soft shadow of the key light, from the
// depth picture), shade (hemisphere, key, fill and rim light, ground shadow, background), reduce (average of n x n).
#pragma once

#include <memory>

#include "geometry/base/error.h"
#include "geometry/mesh/mesh.h"
#include "ui/app/camera.h"
#include "ui/window/image.h"

namespace kerf {

struct RenderOptions {
  int supersampling = 3;       ///< n x n points per pixel, 1 to 4; 1 leaves jagged edges
  int occlusion_samples = 16;  ///< per point, 0 to 64; 0 turns crevice darkening and shadows off
  bool ground_shadow = true;   ///< soft shadow on the plane under the lowest point (z), seen from above only
  bool transparent = false;    ///< no background, no ground shadow: alpha is how much of a pixel the mesh covers
};

constexpr Rgba8 kIvory = {233, 221, 197, 255};  ///< a mesh without colours

/// Needs its OpenGL context current on the calling thread in every call, the destructor included.
class Renderer {
 public:
  static Expected<std::unique_ptr<Renderer>> create();
  ~Renderer();

  /// Uploads the mesh. Face colours win over vertex colours; without any the mesh is ivory. Creases over 40 deg stay
  /// sharp. An empty mesh draws as background. About 80 bytes of GPU memory per triangle.
  void setMesh(const Mesh& mesh);

  /// Draws into the framebuffer that is bound, width x height pixels.
  Expected<void> draw(const Camera& camera, int width, int height, const RenderOptions& options);
  /// The picture, at most 8192 pixels a side. Same mesh, camera, options and driver: the same bytes.
  Expected<Image> picture(const Camera& camera, int width, int height, const RenderOptions& options);

 private:
  Renderer();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf
