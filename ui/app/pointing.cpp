#include "ui/app/pointing.h"

#include "ui/app/command_words.h"

namespace kerf {

Expected<Ray> pointedRay(const AppContext& c, AppWords words) {
  if (!words.empty()) return rayOf(c, words);
  if (!c.pointer) return wrongWord("no pixel", "X Y, or the cursor over the object");
  return rayUnder(c.camera, (*c.pointer)[0], (*c.pointer)[1], c.width, c.height);
}

Expected<Ray> rayOf(const AppContext& c, AppWords words, std::size_t n) {
  KERF_TRY(x, numberOf(words, n, "X", -1e5, 1e5));
  KERF_TRY(y, numberOf(words, n + 1, "Y", -1e5, 1e5));
  return rayUnder(c.camera, x, y, c.width, c.height);
}

Ray rayUnder(const Camera& camera, double x, double y, int width, int height) {
  constexpr double kOff = 300;  // mm: farther off than any case is large
  const double mm = camera.mmPerPixel(height);
  Ray ray;
  ray.direction = -camera.backwards();
  ray.origin = camera.target + mm * (x - 0.5 * width) * camera.right() - mm * (y - 0.5 * height) * camera.up() +
               kOff * camera.backwards();
  return ray;
}

std::array<double, 2> pixelOf(const Camera& camera, const Vec3d& point, int width, int height) {
  const Vec3d from_target = (point - camera.target) / camera.mmPerPixel(height);
  return {0.5 * width + camera.right().dot(from_target), 0.5 * height - camera.up().dot(from_target)};
}

void fitToBox(Camera& camera, const Box3& box, int width, int height) {
  if (box.isEmpty()) return;
  Mesh corners;
  for (int n = 0; n < 8; ++n) corners.vertices.push_back(box.corner(n));
  fitTo(camera, corners, width, height);
}

}  // namespace kerf
