#include "ui/app/commands/command_tables.h"

#include <algorithm>
#include <array>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/sawing.h"

namespace kerf::saw_commands {
namespace {

constexpr double kMostSawMm = 1000, kMostDegrees = 360;
constexpr double kUnderFace = 1;     // mm
constexpr double kUnderCusps = -12;  // mm: a base of usual height

Expected<std::string> sawWordOf(AppWords words, const char* name) {
  if (words.empty() || words[0].empty()) return wrongWord("too few parameters", name);
  return words[0];
}

Expected<void> pick(AppContext& c, SawPicking::What what) {
  if (what != SawPicking::What::kNothing) KERF_CHECK(c.bench.saw->requireUnmoved());
  c.bench.saw->picking.begin(what);
  return {};
}

bool hasPlane(const AppContext& c) { return c.bench.document->isOpen() && c.bench.saw->plan().chosen(); }
bool isCutting(const AppContext& c) { return c.bench.saw->isCutting(); }
bool isPicking(const AppContext& c) { return c.bench.saw->picking.what() != SawPicking::What::kNothing; }

Expected<void> fromPoints(AppContext& c, AppWords words) {
  KERF_TRY(first, rayOf(c, words, 0));
  KERF_TRY(second, rayOf(c, words, 2));
  KERF_TRY(third, rayOf(c, words, 4));
  return c.bench.saw->addThrough({first, second, third});
}

Expected<void> line(AppContext& c, AppWords words) {
  KERF_TRY(from, rayOf(c, words, 0));
  KERF_TRY(to, rayOf(c, words, 2));
  return c.bench.saw->addAlongLine(from, to);
}

Expected<void> fromView(AppContext& c, AppWords words) {
  Ray at = rayUnder(c.camera, 0.5 * c.width, 0.5 * c.height, c.width, c.height);
  if (!words.empty()) {
    KERF_TRY(under, rayOf(c, words));
    at = under;
  }
  const Vec3d right = c.camera.right();
  return c.bench.saw->addFromView(at, (right - at.direction.dot(right) * at.direction).normalized());
}

Expected<void> fromFace(AppContext& c, AppWords words) {
  KERF_TRY(at, rayOf(c, words));
  KERF_TRY(below, numberOr(words, 2, kUnderFace, "MM", 0, kMostSawMm));
  return c.bench.saw->addAlongFace(at, below);
}

Expected<void> fromNumbers(AppContext& c, AppWords words) {
  std::array<double, 6> v{};
  static constexpr std::array<const char*, 6> kNames = {"X", "Y", "Z", "NX", "NY", "NZ"};
  for (std::size_t n = 0; n < v.size(); ++n) {
    KERF_TRY(value, numberOf(words, n, kNames[n], -kMostSawMm, kMostSawMm));
    v[n] = value;
  }
  return c.bench.saw->addAt({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

Expected<void> pickPoints(AppContext& c, AppWords) { return pick(c, SawPicking::What::kPoints); }
Expected<void> pickLine(AppContext& c, AppWords) { return pick(c, SawPicking::What::kLine); }
Expected<void> pickFace(AppContext& c, AppWords) { return pick(c, SawPicking::What::kFace); }
Expected<void> pickNothing(AppContext& c, AppWords) { return pick(c, SawPicking::What::kNothing); }

Expected<void> choose(AppContext& c, AppWords words) {
  KERF_TRY(name, sawWordOf(words, "NAME"));
  return c.bench.saw->plan().choose(name);
}

Expected<void> rename(AppContext& c, AppWords words) {
  KERF_TRY(name, sawWordOf(words, "NAME"));
  return c.bench.saw->plan().renameChosen(name);
}

Expected<void> remove(AppContext& c, AppWords) {
  c.bench.saw->plan().removeChosen();
  return {};
}

Expected<void> move(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOf(words, 0, "MM", -kMostSawMm, kMostSawMm));
  return c.bench.saw->move(mm);
}

Expected<void> turn(AppContext& c, AppWords words) {
  KERF_TRY(deg, numberOf(words, 0, "DEG", -kMostDegrees, kMostDegrees));
  return c.bench.saw->turn(deg, 0);
}

Expected<void> tilt(AppContext& c, AppWords words) {
  KERF_TRY(deg, numberOf(words, 0, "DEG", -kMostDegrees, kMostDegrees));
  return c.bench.saw->turn(0, deg);
}

Expected<void> approach(AppContext& c, AppWords words) {
  KERF_TRY(deg, numberOf(words, 0, "DEG", -kMostDegrees, kMostDegrees));
  return c.bench.saw->turnApproach(deg);
}

Expected<void> width(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOf(words, 0, "MM", SawPlan::kLeastSide, SawPlan::kMostSide));
  return c.bench.saw->resize(mm, {});
}

Expected<void> depth(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOf(words, 0, "MM", SawPlan::kLeastSide, SawPlan::kMostSide));
  return c.bench.saw->resize({}, mm);
}

Expected<void> fit(AppContext& c, AppWords) { return c.bench.saw->fit(); }

Expected<void> save(AppContext& c, AppWords words) {
  KERF_TRY(file, sawWordOf(words, "FILE"));
  return c.bench.saw->save(file);
}

Expected<void> load(AppContext& c, AppWords words) {
  KERF_TRY(file, sawWordOf(words, "PATH"));
  return c.bench.saw->load(file);
}

Expected<void> cut(AppContext& c, AppWords words) {
  KERF_TRY(force, numberOr(words, 0, c.bench.saw->force, "NEWTONS", Sawing::kLeastForce, Sawing::kMostForce));
  return c.bench.saw->cut(force);
}

Expected<void> occlusal(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOr(words, 0, kUnderCusps, "MM", -kMostSawMm, kMostSawMm));
  return c.bench.saw->addOcclusal(mm);
}

Expected<void> cutAtOnce(AppContext& c, AppWords words) {
  const std::string side = words.empty() || words[0].empty() ? "both" : words[0];
  const std::array<const char*, 3> sides{"both", "above", "below"};
  const auto at = std::find(sides.begin(), sides.end(), side);
  if (at == sides.end()) return wrongWord("\"" + side + "\"", "both, above or below");
  KERF_TRY(kerf, numberOr(words, 1, 0, "KERF", 0, CutPlanes::kMostKerf));
  return c.bench.saw->cutAtOnce(static_cast<PlaneKeep>(at - sides.begin()), kerf);
}

Expected<void> keepAbove(AppContext& c, AppWords) { return c.bench.saw->cutAtOnce(PlaneKeep::kAbove, 0); }
Expected<void> keepBelow(AppContext& c, AppWords) { return c.bench.saw->cutAtOnce(PlaneKeep::kBelow, 0); }
Expected<void> keepBoth(AppContext& c, AppWords) { return c.bench.saw->cutAtOnce(PlaneKeep::kBoth, 0); }

Expected<void> stop(AppContext& c, AppWords) {
  c.bench.saw->stop();
  return {};
}

Expected<void> guide(AppContext& c, AppWords words) {
  Sawing& saw = *c.bench.saw;
  if (!words.empty() && words[0] != "on" && words[0] != "off") return wrongWord("\"" + words[0] + "\"", "on or off");
  saw.guide = words.empty() ? !saw.guide : words[0] == "on";
  return {};
}

Expected<void> handles(AppContext& c, AppWords words) {
  Sawing& saw = *c.bench.saw;
  if (!words.empty() && words[0] != "on" && words[0] != "off") return wrongWord("\"" + words[0] + "\"", "on or off");
  saw.has_handles = words.empty() ? !saw.has_handles : words[0] == "on";
  return {};
}

constexpr AppCommand kRows[] = {
    {"saw.pick-points", "Saw", "Plan plane from three points", "P", "",
     "Picks three points of the surface with the mouse.", when::isOpen, pickPoints},
    {"saw.pick-line", "Saw", "Plan plane from a line", "L", "", "Draws a line across the bone with the mouse.",
     when::isOpen, pickLine},
    {"saw.pick-face", "Saw", "Plan plane under a face", "", "", "Picks a face with the mouse.", when::isOpen, pickFace},
    {"saw.pick-nothing", "Saw", "Cancel picking", "Esc", "", "Cancels picking without a plane.", isPicking,
     pickNothing},
    {"saw.plane-from-points", "", "", "", "X1 Y1 X2 Y2 X3 Y3",
     "Plans a plane through three points of the surface, at pixels.", when::isOpen, fromPoints},
    {"saw.line", "", "", "", "X1 Y1 X2 Y2", "Plans a plane through a line in the picture, along the viewing direction.",
     when::isOpen, line},
    {"saw.plane-from-view", "Saw", "Plan plane edge-on in view", "", "[X Y]",
     "Plans an edge-on plane through the centre of the view or a pixel.", when::isOpen, fromView},
    {"saw.plane-from-face", "", "", "", "X Y [MM]",
     "Plans a plane parallel to the surface at a pixel (default: 1 mm below it).", when::isOpen, fromFace},
    {"saw.plane", "", "", "", "X Y Z NX NY NZ", "Plans a plane from a point, in mm, and a normal.", when::isOpen,
     fromNumbers},
    {"saw.plane-occlusal", "Saw", "Plan plane under the cusps", "", "[MM]",
     "Plans a plane parallel to the occlusal plane, MM above it (default -12).", when::isOpen, occlusal},
    {"saw.choose", "", "", "", "NAME", "Chooses another planned plane.", hasPlane, choose},
    {"saw.rename", "", "", "", "NAME", "Renames the chosen plane.", hasPlane, rename},
    {"saw.delete", "Saw", "Delete plane", "", "", "Deletes the chosen plane.", hasPlane, remove},
    {"saw.move", "", "", "", "MM", "Moves the chosen plane along its normal.", hasPlane, move},
    {"saw.turn", "", "", "", "DEG", "Turns the chosen plane about its approach direction.", hasPlane, turn},
    {"saw.tilt", "", "", "", "DEG", "Tilts the chosen plane about its line along the teeth.", hasPlane, tilt},
    {"saw.approach", "", "", "", "DEG", "Turns the approach direction within the chosen plane.", hasPlane, approach},
    {"saw.width", "", "", "", "MM", "Limits the chosen plane along the teeth, at most to the blade.", hasPlane, width},
    {"saw.depth", "", "", "", "MM", "Limits the depth of the chosen plane, at most to the reach of the blade.",
     hasPlane, depth},
    {"saw.fit", "Saw", "Fit plane to bone and blade", "", "", "Limits the chosen plane to bone and blade again.",
     hasPlane, fit},
    {"saw.save", "", "", "", "FILE", "Writes all planned planes to a file.", when::isOpen, save},
    {"saw.load", "Saw", "Open saw plan...", "", "PATH",
     "Reads planned planes from a file, also of 3D Slicer (.mrk.json), or a session folder.", when::isOpen, load},
    {"saw.cut", "Saw", "Cut this plane", "", "[NEWTONS]",
     "Cuts the chosen plane with the current saw. NEWTONS limits the push (default 5 N).", hasPlane, cut},
    {"plane.cut", "", "", "", "[both|above|below] [KERF]",
     "Cuts by the chosen plane at once and exactly, without bounds. Above is the side of its arrow. KERF in mm is "
     "lost.",
     hasPlane, cutAtOnce},
    {"plane.cut-keep-both", "Saw:2", "Cut at once, keep both", "", "", "Cuts by the chosen plane at once.", hasPlane,
     keepBoth},
    {"plane.cut-keep-above", "Saw:2", "Cut at once, keep above", "", "",
     "Cuts by the chosen plane at once and removes the part below.", hasPlane, keepAbove},
    {"plane.cut-keep-below", "Saw:2", "Cut at once, keep below", "", "",
     "Cuts by the chosen plane at once and removes the part above.", hasPlane, keepBelow},
    {"plane.handles", "Saw:2", "Handles on plane", "", "[on|off]",
     "Shows handles on the chosen plane, to move and turn it by mouse.", when::isOpen, handles},
    {"saw.stop", "Saw", "Stop sawing", "", "", "Stops a planned cut and retracts the blade.", isCutting, stop},
    {"saw.guide", "Saw", "Guide blade", "G", "[on|off]", "Keeps a mouse-guided saw in the chosen plane, or frees it.",
     when::isOpen, guide},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::saw_commands
