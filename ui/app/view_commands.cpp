#include "ui/app/view_commands.h"

#include <algorithm>
#include <cmath>

#include "ui/app/command_words.h"
#include "ui/app/pointing.h"

namespace kerf::view_commands {
namespace {

Expected<void> moveSection(AppContext& c, AppWords words, double way) {
  KERF_TRY(mm, numberOr(words, 0, 0.2, "MM", 0, 1000));
  c.bench.section->point += way * mm * c.bench.section->normal;
  return {};
}

}  // namespace

bool hasSection(const AppContext& c) { return c.bench.isOpen() && c.bench.section.has_value(); }

Expected<void> fit(AppContext& c, AppWords) {
  fitToBox(c.camera, c.bench.scene().bounds(), c.width, c.height);
  return {};
}

Expected<void> view(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no view", "its name");
  KERF_TRY(named, cameraFromView(words[0]));
  const Eigen::Matrix3d upright = c.camera.upright;
  c.camera = named;
  c.camera.upright = upright;
  return fit(c, {});
}

Expected<void> up(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no side", "+x, -x, +y, -y, +z, -z or auto");
  const Vec3d found = c.bench.occlusalNormal().value_or(Vec3d::UnitZ());
  KERF_TRY(side, words[0] == "auto" ? Expected<Vec3d>(found) : axisFromName(words[0]));
  c.camera.upright = uprightFrame(side);
  return fit(c, {});
}

// Square to the view: what is nearer than a point goes.
Expected<void> cutOpen(AppContext& c, AppWords words) {
  if (c.bench.section && words.empty()) {
    c.bench.section.reset();
    return {};
  }
  Vec3d through = c.bench.scene().bounds().center();
  if (!words.empty() || c.pointer) {
    KERF_TRY(ray, pointedRay(c, words));
    if (const auto hit = c.bench.scene().hit(ray)) through = hit->on_surface.point;
  }
  c.bench.section = Plane{through, c.camera.backwards()};
  return {};
}

Expected<void> sectionDeeper(AppContext& c, AppWords words) { return moveSection(c, words, -1); }
Expected<void> sectionNearer(AppContext& c, AppWords words) { return moveSection(c, words, 1); }

Expected<void> zoom(AppContext& c, AppWords words) {
  KERF_TRY(factor, numberOf(words, 0, "FACTOR", 0.01, 100));
  zoomBy(c.camera, factor);
  return {};
}

Expected<void> plots(AppContext& c, AppWords words) {
  if (words.empty())
    c.shows_plots = !c.shows_plots;
  else if (words[0] == "on" || words[0] == "off")
    c.shows_plots = words[0] == "on";
  else
    return wrongWord("\"" + words[0] + "\"", "on or off");
  return {};
}

Expected<void> screenshot(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  if (c.screenshot) return c.screenshot(path);
  return wrongWord("nothing is drawn here", "a window, or a picture without one");
}

}  // namespace kerf::view_commands

namespace kerf {

void firstView(AppContext& context, const Camera& otherwise) {
  context.camera = otherwise;
  if (const auto& normal = context.bench.occlusalNormal()) {
    constexpr double kFromAbove = 1.5;  // rad
    context.camera.upright = uprightFrame(*normal);
    if (otherwise.elevation > kFromAbove) lookFrom(context.camera, *normal);
  }
  fitToBox(context.camera, context.bench.scene().bounds(), context.width, context.height);
}

}  // namespace kerf
