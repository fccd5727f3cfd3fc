// Dental views: occlusal, buccal, lingual, mesial, distal.
//
// Each view shows a place: a script's pixel, else the point under the cursor, else the chosen piece, else the middle of
// the view, else the nearest part of the arch. The arch's curve (dental_arch.h) gives the sides there; for a moved
// piece, at its place in the scan. Without a full arch the user sets the sides: sides() and sidesHere(). Until then
// these views give an error with a remedy.
//
// The place comes to the middle of the picture, 24 mm from lower to upper edge, or less if the view was nearer. The
// occlusal side is up; in the occlusal view, the front of the arch, or the buccal side if the user set the sides. The
// view looks over obstacles: lingual from 30 degrees above the occlusal plane, over the teeth of the other side; mesial
// and distal from 45, over the adjacent teeth; buccal from within the plane. If the user set the sides, it is one
// tooth, and all four look from within the plane.
#include "ui/app/commands/command_tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"
#include "ui/app/workbench/scene_pieces.h"

namespace kerf::tooth_views {
namespace {

enum class ToothSide { kOcclusal, kBuccal, kLingual, kMesial, kDistal };

constexpr double kToothDegree = std::numbers::pi / 180;
constexpr double kHalfHeight = 12;                   // mm: a tooth and the adjacent ones
constexpr double kOverTheArch = 30, kOverNext = 45;  // degrees above the occlusal plane

/// Place of a view.
struct ToothPlace {
  Vec3d point = Vec3d::Zero();  // world
  Rigid3 T_world_object;
};

std::optional<ToothPlace> placeUnder(const AppContext& c, const Ray& ray) {
  const auto seen = c.bench.views->behindSection(ray);
  const auto hit = seen ? c.bench.document->scene().hit(*seen) : std::nullopt;
  if (!hit) return {};
  const SceneObject* const object = c.bench.document->scene().find(hit->id);
  return ToothPlace{hit->on_surface.point, object ? object->pose() : Rigid3{}};
}

/// The point of the arch nearest to a ray.
ToothPlace placeOfArch(const DentalArch& arch, const Ray& ray) {
  const auto off = [&](const Vec3d& p) { return (p - ray.origin).cross(ray.direction).squaredNorm(); };
  return {*std::min_element(arch.curve.begin(), arch.curve.end(),
                            [&](const Vec3d& a, const Vec3d& b) { return off(a) < off(b); }),
          {}};
}

Expected<ToothPlace> toothPlaceOf(const AppContext& c, AppWords words) {
  if (!words.empty()) {
    KERF_TRY(ray, rayOf(c, words));
    if (const auto place = placeUnder(c, ray)) return *place;
    return wrongWord("nothing is there", "a pixel of the object");
  }
  const auto rayAt = [&](double x, double y) { return rayUnder(c.camera, x, y, c.width, c.height); };
  if (c.pointer)
    if (const auto place = placeUnder(c, rayAt((*c.pointer)[0], (*c.pointer)[1]))) return *place;
  if (const SceneObject* const piece = c.bench.pieces->chosen())
    return ToothPlace{piece->pose() * piece->surface.bounds().center(), piece->pose()};

  const Ray middle = rayAt(0.5 * c.width, 0.5 * c.height);
  if (const auto place = placeUnder(c, middle)) return *place;
  if (const auto& arch = c.bench.document->occlusal().arch; arch && !c.bench.views->told_sides)
    return placeOfArch(*arch, middle);
  return ToothPlace{c.bench.document->scene().bounds().center(), {}};
}

/// In the world's frame.
Expected<ToothSides> sidesOf(const AppContext& c, const ToothPlace& place) {
  ToothSides out;
  if (c.bench.views->told_sides)
    out = *c.bench.views->told_sides;
  else if (const auto& arch = c.bench.document->occlusal().arch)
    out = arch->sidesAt(place.T_world_object.inverse() * place.point);
  else
    return fail({.code = Error::Code::kUnsupported,
                 .found = "no full arch of teeth to find the sides from",
                 .expected = "sides set by the user",
                 .hint = "turn the view to the buccal side, then View > Set as buccal; in a script view.sides +y +x "
                         "(buccal and mesial axes)"});
  for (Vec3d* const side : {&out.occlusal, &out.buccal, &out.mesial}) *side = place.T_world_object.rotation * *side;
  return out;
}

/// Up in the view: exactly out of the teeth, unless the user has turned another side up.
Vec3d upOf(const AppContext& c) {
  const auto& occlusal = c.bench.document->occlusal().normal;
  if (occlusal && uprightFrame(*occlusal) == c.camera.upright) return *occlusal;
  return c.camera.upright.transpose() * Vec3d::UnitZ();
}

Expected<void> look(AppContext& c, AppWords words, ToothSide side) {
  KERF_TRY(place, toothPlaceOf(c, words));
  KERF_TRY(sides, sidesOf(c, place));
  const bool is_one_tooth = c.bench.views->told_sides.has_value();
  const auto from = [&](const Vec3d& direction, double above_deg) {
    const double above = is_one_tooth ? 0 : above_deg * kToothDegree;
    lookFrom(c.camera, std::cos(above) * direction + std::sin(above) * sides.occlusal, sides.occlusal);
  };

  switch (side) {
    case ToothSide::kOcclusal:
      lookFrom(c.camera, sides.occlusal,
               is_one_tooth ? sides.buccal
                            : Vec3d(place.T_world_object.rotation * c.bench.document->occlusal().arch->front));
      break;
    case ToothSide::kBuccal:
      from(sides.buccal, 0);
      break;
    case ToothSide::kLingual:
      from(-sides.buccal, kOverTheArch);
      break;
    case ToothSide::kMesial:
      from(sides.mesial, kOverNext);
      break;
    case ToothSide::kDistal:
      from(-sides.mesial, kOverNext);
      break;
  }
  c.camera.target = place.point;
  c.camera.half_height = std::min(c.camera.half_height, kHalfHeight);
  return {};
}

Expected<void> sides(AppContext& c, AppWords words) {
  if (words.size() == 1 && words[0] == "auto") {
    c.bench.views->told_sides.reset();
    return {};
  }
  if (words.size() < 2)
    return wrongWord("too few words", "the buccal and the mesial axis, or auto", "view.sides +y +x");
  ToothSides told;
  KERF_TRY(buccal, axisFromName(words[0]));
  KERF_TRY(mesial, axisFromName(words[1]));
  told.buccal = buccal;
  told.mesial = mesial;
  told.occlusal = buccal.cross(mesial);
  const Vec3d up = upOf(c);
  if (told.occlusal.dot(up) < 0) told.occlusal = -told.occlusal;
  if (told.occlusal.dot(up) < std::numbers::sqrt2 / 2)
    return wrongWord(words[0] + " and " + words[1], "two axes square to the up axis, " + nameOfAxis(up),
                     "set the up axis with view.up");
  c.bench.views->told_sides = told;
  return {};
}

Expected<void> sidesHere(AppContext& c, AppWords words) {
  if (words.empty() || (words[0] != "left" && words[0] != "right"))
    return wrongWord(words.empty() ? "no side" : "\"" + words[0] + "\"",
                     "left or right: the position of the mesial side");
  constexpr double kAside = 0.5;  // sine of the least angle to the occlusal axis: 30 degrees
  ToothSides told;
  told.occlusal = upOf(c).normalized();
  const Vec3d back = c.camera.backwards(), level = back - told.occlusal.dot(back) * told.occlusal;
  if (level.norm() < kAside)
    return fail(
        {.code = Error::Code::kUnsupported,
         .found = "a view along the occlusal axis",
         .expected = "a view of the buccal side",
         .hint = "turn the view with the right button until the buccal side faces you, then repeat the command"});
  told.buccal = level.normalized();
  told.mesial = told.occlusal.cross(told.buccal);
  if (told.mesial.dot(c.camera.right()) * (words[0] == "right" ? 1 : -1) < 0) told.mesial = -told.mesial;
  c.bench.views->told_sides = told;
  return {};
}

template <ToothSide kSide>
Expected<void> lookAt(AppContext& context, AppWords words) {
  return look(context, words, kSide);
}

template <bool kMesialIsLeft>
Expected<void> thisIsBuccal(AppContext& context, AppWords) {
  const std::string words[] = {kMesialIsLeft ? "left" : "right"};
  return sidesHere(context, words);
}

constexpr AppCommand kRows[] = {
    {"view.occlusal", "View:2>Sides of a tooth", "Occlusal: this tooth", "0", "[X Y]",
     "Looks at a tooth square to the occlusal plane, with the front of the arch up. The tooth is at a pixel, under the "
     "cursor, the chosen piece, or at the centre of the view.",
     when::isShown, lookAt<ToothSide::kOcclusal>},
    {"view.buccal", "View:2>Sides of a tooth", "Buccal: this tooth", "8", "[X Y]",
     "Looks at the buccal (labial) side of a tooth, from outside the arch.", when::isShown, lookAt<ToothSide::kBuccal>},
    {"view.lingual", "View:2>Sides of a tooth", "Lingual: this tooth", "9", "[X Y]",
     "Looks at the lingual (palatal) side of a tooth, from inside the arch and 30 degrees above it.", when::isShown,
     lookAt<ToothSide::kLingual>},
    {"view.mesial", "View:2>Sides of a tooth", "Mesial: this tooth", "Shift+8", "[X Y]",
     "Looks at the mesial side of a tooth, along the arch from its midline and 45 degrees above it.", when::isShown,
     lookAt<ToothSide::kMesial>},
    {"view.distal", "View:2>Sides of a tooth", "Distal: this tooth", "Shift+9", "[X Y]",
     "Looks at the distal side of a tooth, along the arch from its end and 45 degrees above it.", when::isShown,
     lookAt<ToothSide::kDistal>},
    {"view.sides", "", "", "", "BUCCAL MESIAL|auto",
     "Sets the buccal and the mesial side if the scan has no full arch: +x, -x, +y, -y, +z, -z; auto: from the arch.",
     when::isShown, sides},
    {"view.sides-here", "", "", "", "left|right",
     "Sets this view as the buccal side, with mesial to the left or right.", when::isShown, sidesHere},
    {"view.sides-left", "View:2>Sides of a tooth", "Set as buccal, mesial left", "", "",
     "Sets this view as the buccal side, with mesial to the left.", when::isShown, thisIsBuccal<true>},
    {"view.sides-right", "View:2>Sides of a tooth", "Set as buccal, mesial right", "", "",
     "Sets this view as the buccal side, with mesial to the right.", when::isShown, thisIsBuccal<false>},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::tooth_views
