#include "ui/app/commands/zoom.h"

#include <algorithm>

#include "ui/app/commands/pointing.h"

namespace kerf {

void orbitAbout(Camera& camera, const Vec3d& pivot, double dx, double dy) {
  const Vec3d in_view = camera.rotation() * (pivot - camera.target);
  orbit(camera, dx, dy);
  camera.target = pivot - camera.rotation().transpose() * in_view;
}

void zoomAt(AppContext& context, double x, double y, double factor) {
  Camera& camera = context.camera;
  if (const auto point = pointUnder(context, x, y)) focusOn(camera, *point);

  const double right = x - 0.5 * context.width, down = y - 0.5 * context.height;
  pan(camera, -right, -down, context.height);
  zoomBy(camera, factor);
  pan(camera, right, down, context.height);
}

void fitToBox(Camera& camera, const Box3& box, int width, int height) {
  if (box.isEmpty()) return;
  Mesh corners;
  for (int n = 0; n < 8; ++n) corners.vertices.push_back(box.corner(n));
  fitTo(camera, corners, width, height);
}

void fitToFree(AppContext& context, const Box3& box) {
  constexpr int kLeast = 64;  // pixels
  const ViewMargins& covered = context.margins;
  const int width = std::max(context.width - covered.left - covered.right, kLeast);
  const int height = std::max(context.height - covered.top - covered.bottom, kLeast);
  Camera& camera = context.camera;
  fitToBox(camera, box, width, height);
  camera.half_height *= static_cast<double>(context.height) / height;
  pan(camera, 0.5 * (covered.left - covered.right), 0.5 * (covered.top - covered.bottom), context.height);
}

}  // namespace kerf
