#include "ui/app/commands/zoom.h"

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

}  // namespace kerf
