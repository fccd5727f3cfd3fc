#include "ui/app/commands/view_commands.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/commands/settings.h"

namespace kerf::view_commands {
namespace {

constexpr double kViewDegree = std::numbers::pi / 180;
constexpr double kFarOff = 1e5;  // pixels

Expected<void> moveSection(AppContext& c, AppWords words, double way) {
  KERF_TRY(mm, numberOr(words, 0, 0.2, "MM", 0, 1000));
  c.bench.section->point += way * mm * c.bench.section->normal;
  return {};
}

}  // namespace

bool hasSection(const AppContext& c) { return c.bench.isShown() && c.bench.section.has_value(); }

Expected<void> fit(AppContext& c, AppWords) {
  fitToBox(c.camera, c.bench.scene().bounds(), c.width, c.height);
  return {};
}

Expected<void> view(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no view", "its name");
  KERF_TRY(named, cameraFromView(words[0]));
  named.upright = c.camera.upright;
  named.field_of_view = c.camera.field_of_view;
  c.camera = named;
  return fit(c, {});
}

Expected<void> up(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no side", "+x, -x, +y, -y, +z, -z or auto");
  const Vec3d found = c.bench.occlusalNormal().value_or(Vec3d::UnitZ());
  KERF_TRY(side, words[0] == "auto" ? Expected<Vec3d>(found) : axisFromName(words[0]));
  c.camera.upright = uprightFrame(side);
  return fit(c, {});
}

// Perpendicular to the view: removes everything nearer than a point.
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
  if (words.size() < 2) {
    zoomBy(c.camera, factor);
    return {};
  }
  KERF_TRY(x, numberOf(words, 1, "X", -kFarOff, kFarOff));
  KERF_TRY(y, numberOf(words, 2, "Y", -kFarOff, kFarOff));
  zoomAt(c, x, y, factor);
  return {};
}

Expected<void> perspective(AppContext& c, AppWords words) {
  const double kept = c.settings ? c.settings->values.perspective_deg : Settings{}.perspective_deg;
  const auto keep = [&c](bool is_on) -> Expected<void> {
    if (!c.settings) return {};
    c.settings->values.is_perspective = is_on;
    return c.settings->save();
  };
  if (words.empty() ? c.camera.isPerspective() : words[0] == "off") {
    setFieldOfView(c.camera, 0);
    return keep(false);
  }
  KERF_TRY(degrees, numberOr(words, 0, kept, "DEG", Camera::kLeastField, Camera::kMostField));
  setFieldOfView(c.camera, degrees * kViewDegree);
  if (c.settings && !words.empty()) c.settings->values.perspective_deg = degrees;
  return keep(true);
}

Expected<void> roll(AppContext& c, AppWords words) {
  KERF_TRY(degrees, numberOr(words, 0, 15, "DEG", -360, 360));
  c.camera.roll = std::remainder(c.camera.roll + degrees * kViewDegree, 2 * std::numbers::pi);
  return {};
}

Expected<void> level(AppContext& c, AppWords) {
  c.camera.roll = 0;
  return {};
}

bool isRolled(const AppContext& c) { return c.camera.roll != 0; }

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
  const double field_of_view = context.camera.field_of_view;
  context.camera = otherwise;
  context.camera.field_of_view = field_of_view;
  if (const auto& normal = context.bench.occlusalNormal()) {
    constexpr double kFromAbove = 1.5;  // rad
    context.camera.upright = uprightFrame(*normal);
    if (otherwise.elevation > kFromAbove) lookFrom(context.camera, *normal);
  }
  fitToBox(context.camera, context.bench.scene().bounds(), context.width, context.height);
}

}  // namespace kerf
