#include "ui/app/commands/command_tables.h"

#include <array>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/sawing.h"

namespace kerf::saw_commands {
namespace {

constexpr double kMostSawMm = 1000, kMostDegrees = 360;
constexpr double kUnderFace = 1;  // mm

Expected<std::string> sawWordOf(AppWords words, const char* name) {
  if (words.empty() || words[0].empty()) return wrongWord("too few parameters", name);
  return words[0];
}

Expected<void> pick(AppContext& c, SawPicking::What what) {
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
  KERF_TRY(file, sawWordOf(words, "FILE"));
  return c.bench.saw->load(file);
}

Expected<void> cut(AppContext& c, AppWords words) {
  KERF_TRY(force, numberOr(words, 0, c.bench.saw->force, "NEWTONS", Sawing::kLeastForce, Sawing::kMostForce));
  return c.bench.saw->cut(force);
}

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

constexpr AppCommand kRows[] = {
    {"saw.pick-points", "Saw", "Plane from three points", "P", "", "Picks three points of the surface, by mouse.",
     when::isOpen, pickPoints},
    {"saw.pick-line", "Saw", "Plane from a line", "L", "", "Draws a line across the bone, by mouse.", when::isOpen,
     pickLine},
    {"saw.pick-face", "Saw", "Plane under a face", "", "", "Picks a face, by mouse.", when::isOpen, pickFace},
    {"saw.pick-nothing", "Saw", "Leave picking", "Esc", "", "Leaves picking; nothing is planned.", isPicking,
     pickNothing},
    {"saw.plane-from-points", "", "", "", "X1 Y1 X2 Y2 X3 Y3",
     "Plans a plane through three points of the surface, at pixels.", when::isOpen, fromPoints},
    {"saw.line", "", "", "", "X1 Y1 X2 Y2", "Plans a plane through a line of the picture, along the view.",
     when::isOpen, line},
    {"saw.plane-from-view", "Saw", "Plane upright in this view", "", "[X Y]",
     "Plans a plane that is seen edge-on, through the middle of the view or a pixel.", when::isOpen, fromView},
    {"saw.plane-from-face", "", "", "", "X Y [MM]",
     "Plans a plane parallel to the surface at a pixel, 1 mm under it if not told.", when::isOpen, fromFace},
    {"saw.plane", "", "", "", "X Y Z NX NY NZ", "Plans a plane through a point, mm, square to a normal.", when::isOpen,
     fromNumbers},
    {"saw.choose", "", "", "", "NAME", "Chooses another planned plane.", hasPlane, choose},
    {"saw.rename", "", "", "", "NAME", "Gives the chosen plane another name.", hasPlane, rename},
    {"saw.delete", "Saw", "Delete the plane", "", "", "Takes the chosen plane out of the plan.", hasPlane, remove},
    {"saw.move", "", "", "", "MM", "Moves the chosen plane along its normal.", hasPlane, move},
    {"saw.turn", "", "", "", "DEG", "Turns the chosen plane about the way the teeth go in.", hasPlane, turn},
    {"saw.tilt", "", "", "", "DEG", "Turns the chosen plane about its line along the teeth.", hasPlane, tilt},
    {"saw.approach", "", "", "", "DEG", "Turns, within the chosen plane, the way the teeth go in.", hasPlane, approach},
    {"saw.width", "", "", "", "MM", "Bounds the chosen plane along the teeth, at most to the blade.", hasPlane, width},
    {"saw.depth", "", "", "", "MM", "Bounds how deep the chosen plane goes, at most to the blade's reach.", hasPlane,
     depth},
    {"saw.fit", "Saw", "Fit the plane to bone and blade", "", "", "Bounds the chosen plane to bone and blade anew.",
     hasPlane, fit},
    {"saw.save", "", "", "", "FILE", "Writes all planned planes to a file.", when::isOpen, save},
    {"saw.load", "", "", "", "FILE", "Reads planned planes from a file or a session's folder.", when::isOpen, load},
    {"saw.cut", "Saw", "Cut this plane now", "", "[NEWTONS]",
     "Saws the chosen plane with the saw in hand, pushed with 5 N at most if not told.", hasPlane, cut},
    {"saw.stop", "Saw", "Stop sawing", "", "", "Breaks a planned cut off and draws the blade out.", isCutting, stop},
    {"saw.guide", "Saw", "Guide the blade", "G", "[on|off]",
     "Keeps a saw moved by mouse in the chosen plane, or lets it free.", when::isOpen, guide},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::saw_commands
