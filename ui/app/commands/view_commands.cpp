#include "ui/app/commands/view_commands.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/command_tables.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/commands/zoom.h"
#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"
#include "ui/app/import/import_set.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/imports.h"

namespace kerf::view_commands {
namespace {

constexpr double kViewDegree = std::numbers::pi / 180;
constexpr double kFarOff = 1e5;  // pixels

Expected<void> moveSection(AppContext& c, AppWords words, double way) {
  KERF_TRY(mm, numberOr(words, 0, 0.2, "MM", 0, 1000));
  c.bench.views->section->point += way * mm * c.bench.views->section->normal;
  return {};
}

bool hasSection(const AppContext& c) { return c.bench.document->isShown() && c.bench.views->section.has_value(); }

// Of the open document, or of the scan in the import with room for its guides.
Box3 shownBox(const AppContext& c) {
  const ImportSet* const set = c.bench.imports->set();
  if (!set) return c.bench.document->scene().bounds();
  Box3 box = set->picture(false).box;
  box.grow(0.08 * box.size().norm());
  return box;
}

bool hasBox(const AppContext& c) { return c.bench.document->isShown() || c.bench.imports->set(); }

Expected<void> fit(AppContext& c, AppWords) {
  fitToFree(c, shownBox(c));
  return {};
}

// The front of a full arch is that of its incisors, from any side but above and below.   rad; 0 without an arch.
double azimuthOfFront(const AppContext& c, const Camera& named) {
  constexpr double kSteep = 1.5;  // rad
  const auto& arch = c.bench.document->occlusal().arch;
  if (!arch || c.bench.imports->isImporting() || std::abs(named.elevation) > kSteep) return 0;
  const Vec3d front = c.camera.upright * arch->front;
  return std::hypot(front.x(), front.y()) > 0.5 ? std::atan2(front.x(), -front.y()) : 0;
}

Expected<void> view(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no view", "its name");
  KERF_TRY(named, cameraFromView(words[0]));
  named.upright = c.camera.upright;
  const auto& views = namedViews();
  if (std::any_of(views.begin(), views.end(), [&](const NamedView& v) { return v.name == words[0]; }))
    named.azimuth = std::remainder(named.azimuth + azimuthOfFront(c, named), 2 * std::numbers::pi);
  named.field_of_view = c.camera.field_of_view;
  c.camera = named;
  return fit(c, {});
}

Expected<void> up(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no side", "+x, -x, +y, -y, +z, -z or auto");
  const Vec3d found = c.bench.document->occlusal().normal.value_or(Vec3d::UnitZ());
  KERF_TRY(side, words[0] == "auto" ? Expected<Vec3d>(found) : axisFromName(words[0]));
  c.camera.upright = uprightFrame(side);
  return fit(c, {});
}

// Perpendicular to the view: removes everything nearer than a point.
Expected<void> cutOpen(AppContext& c, AppWords words) {
  if (c.bench.views->section && words.empty()) {
    c.bench.views->section.reset();
    return {};
  }
  Vec3d through = c.bench.document->scene().bounds().center();
  if (!words.empty() || c.pointer) {
    KERF_TRY(ray, pointedRay(c, words));
    if (const auto hit = c.bench.document->scene().hit(ray)) through = hit->on_surface.point;
  }
  c.bench.views->section = Plane{through, c.camera.backwards()};
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

Expected<void> screenshot(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  if (c.screenshot) return c.screenshot(path);
  return wrongWord("no picture: this program draws none", "a window or an offscreen picture");
}

template <std::size_t N>
Expected<void> namedView(AppContext& context, AppWords) {
  const std::string words[] = {std::string(namedViews()[N].name)};
  return view(context, words);
}

constexpr AppCommand kRows[] = {
    {"view.fit", "View:1", "Fit", "F", "", "Shows the whole object.", hasBox, fit},
    {"view.front", "View:2>Directions", "Front", "1", "",
     "Looks at the incisors of a full arch, else along +y, where +z is up.", when::always, namedView<0>},
    {"view.back", "View:2>Directions", "Back", "2", "", "Looks along -y; at a full arch from behind.", when::always,
     namedView<1>},
    {"view.left", "View:2>Directions", "Left", "3", "", "Looks along +x; at a full arch from the left of its front.",
     when::always, namedView<2>},
    {"view.right", "View:2>Directions", "Right", "4", "", "Looks along -x; at a full arch from the right of its front.",
     when::always, namedView<3>},
    {"view.top", "View:2>Directions", "Top", "5", "", "Looks down on the upper side; for a scan the occlusal side.",
     when::always, namedView<4>},
    {"view.bottom", "View:2>Directions", "Bottom", "6", "", "Looks up from below.", when::always, namedView<5>},
    {"view.iso", "View:2>Directions", "Oblique", "7", "", "Looks from the front, above and the right.", when::always,
     namedView<6>},
    {"view.from", "", "", "", "NAME|AZ,EL", "Looks from a named side or two angles in degrees.", when::always, view},
    {"view.up", "", "", "", "AXIS|auto",
     "Sets the side of the scan that is up: +x, -x, +y, -y, +z, -z; auto: the occlusal side, as after opening. "
     "Coordinates stay those of the scan.",
     when::isShown, up},
    {"view.section", "View:3>Section", "Toggle section", "X", "[X Y]",
     "Hides everything in front of the point under the cursor, or of the centre. Again: shows the whole object.",
     when::isShown, cutOpen},
    {"view.section-deeper", "View:3>Section", "Move section deeper", "PageDown", "[MM]",
     "Moves the section deeper (default 0.2 mm).", hasSection, sectionDeeper},
    {"view.section-nearer", "View:3>Section", "Move section nearer", "PageUp", "[MM]",
     "Moves the section back towards its original viewpoint (default 0.2 mm).", hasSection, sectionNearer},
    {"view.plots", "View:5", "Show plots of last 20 s", "", "[on|off]",
     "Shows or hides plots of force, torque, spindle speed, depth and volume rate.", when::always,
     switchPanel<"plots">},
    {"view.details", "", "", "", "[on|off]", "Shows or hides the numbers of the 1 kHz loop.", when::always,
     switchPanel<"details">},
    {"view.zoom", "", "", "", "FACTOR [X Y]", "Zooms by a factor, about the centre of the view or a pixel.",
     when::always, zoom},
    {"view.perspective", "View:4>Projection", "Perspective", "O", "[DEG|off]",
     "Toggles perspective. DEG sets the vertical field of view, 5 to 90 degrees (default: the one of the settings). "
     "Off: parallel projection.",
     when::always, perspective},
    {"view.roll", "View:4>Projection", "Roll view", "R", "[DEG]",
     "Turns the view clockwise in the picture (default 15 degrees).", when::always, roll},
    {"view.level", "View:4>Projection", "Reset roll", "Shift+R", "", "Resets all turns of the view in the picture.",
     isRolled, level},
    {"picture.write", "", "", "", "OUT.png", "Writes the view as a PNG picture.", when::always, screenshot},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::view_commands

namespace kerf {

void firstView(AppContext& context, const Camera& otherwise) {
  const double field_of_view = context.camera.field_of_view;
  context.camera = otherwise;
  context.camera.field_of_view = field_of_view;
  if (const auto& normal = context.bench.document->occlusal().normal) {
    constexpr double kFromAbove = 1.5;  // rad
    context.camera.upright = uprightFrame(*normal);
    if (otherwise.elevation > kFromAbove && context.bench.document->isInOcclusion()) {
      context.camera.elevation = 0;
      context.camera.azimuth = view_commands::azimuthOfFront(context, context.camera);
    } else if (otherwise.elevation > kFromAbove) {
      lookFrom(context.camera, *normal);
    }
  }
  fitToFree(context, context.bench.document->scene().bounds());
}

void viewScan(AppContext& context) {
  const ImportSet* const set = context.bench.imports->set();
  if (!set) return;
  constexpr double kTilt = 0.6;  // rad, off the occlusal view
  context.camera.upright = uprightFrame(set->picture(false).up);
  context.camera.azimuth = context.camera.roll = 0;
  context.camera.elevation = std::numbers::pi / 2 - kTilt;
  fitToFree(context, view_commands::shownBox(context));
}

}  // namespace kerf
