#include "ui/app/commands/pointing.h"

#include <algorithm>

#include "ui/app/base/command_words.h"
#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"
#include "ui/app/workbench/imports.h"

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
  constexpr double kOff = 300;  // mm: larger than any case
  const double mm = camera.mmPerPixel(height);
  const Vec3d off = mm * (x - 0.5 * width) * camera.right() - mm * (y - 0.5 * height) * camera.up();
  if (!camera.isPerspective()) return {camera.target + off + kOff * camera.backwards(), -camera.backwards()};

  const double distance = camera.eyeDistance();
  const Vec3d eye = camera.target + distance * camera.backwards(), to_focus = camera.target + off - eye;
  const double first = std::max(1 - kOff / distance, Camera::kNearest);  // of the way to the focus
  return {eye + first * to_focus, to_focus.normalized()};
}

std::array<double, 2> pixelOf(const Camera& camera, const Vec3d& point, int width, int height) {
  const Vec3d from_target = (point - camera.target) / camera.mmPerPixelAt(point, height);
  return {0.5 * width + camera.right().dot(from_target), 0.5 * height - camera.up().dot(from_target)};
}

std::optional<Vec3d> pointUnder(AppContext& context, double x, double y) {
  if (context.bench.imports->isImporting()) return {};
  const auto seen = context.bench.views->behindSection(rayUnder(context.camera, x, y, context.width, context.height));
  const auto hit = seen ? context.bench.document->scene().hit(*seen) : std::nullopt;
  return hit ? std::optional<Vec3d>(hit->on_surface.point) : std::nullopt;
}

}  // namespace kerf
