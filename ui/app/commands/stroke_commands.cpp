#include "ui/app/commands/command_tables.h"

#include <numbers>
#include <optional>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"

namespace kerf::stroke_commands {
namespace {

constexpr double kHandDegree = std::numbers::pi / 180;

bool isTilted(const AppContext& c) { return !c.bench.strokes->tilt.isUpright(); }

Expected<void> tilt(AppContext& c, AppWords words) {
  constexpr double kUpwards = 90;
  const double before = isTilted(c) ? azimuthInView(c.camera, c.bench.strokes->tilt) / kHandDegree : kUpwards;
  KERF_TRY(angle, numberOf(words, 0, "DEG", 0, Tilt::kMost / kHandDegree));
  KERF_TRY(azimuth, numberOr(words, 1, before, "AZIMUTH", -360, 360));
  c.bench.strokes->tilt = tiltInView(c.camera, angle * kHandDegree, azimuth * kHandDegree);
  return {};
}

Expected<void> resetTilt(AppContext& c, AppWords) {
  c.bench.strokes->tilt = {};
  return {};
}

// Out of the tissue: of the tool under the cursor, else of the last stroke.
Vec3d toolAxis(const AppContext& c) {
  const Vec3d into = c.bench.tools->held().plunge_direction;
  if (c.pointer && !c.bench.strokes->heldAxis())
    if (const auto over =
            c.bench.strokes->over(rayUnder(c.camera, (*c.pointer)[0], (*c.pointer)[1], c.width, c.height)))
      return -(over->T_world_tool.rotation * into);
  return -(c.bench.document->report().output.T_world_tool.rotation * into);
}

Expected<void> holdAxis(AppContext& c, AppWords words) {
  Strokes& strokes = *c.bench.strokes;
  const std::string from = !words.empty() ? words[0] : strokes.heldAxis() ? "off" : "tool";
  if (from == "off") {
    strokes.holdAxis(std::nullopt);
  } else if (from == "tool") {
    strokes.holdAxis(toolAxis(c));
  } else if (from == "view") {
    strokes.holdAxis(c.camera.backwards());
  } else if (from == "occlusal") {
    const auto& normal = c.bench.document->occlusal().normal;
    if (!normal) return wrongWord("a model without an occlusal plane", "tool or view");
    strokes.holdAxis(*normal);
  } else {
    return wrongWord("\"" + from + "\"", "tool, view, occlusal or off");
  }
  return {};
}

bool isCutting(const AppContext& c) { return c.bench.strokes->isPressed(); }

Expected<void> nudge(AppContext& c, AppWords words) {
  constexpr double kMost = 10;  // mm
  KERF_TRY(right, numberOf(words, 0, "RIGHT", -kMost, kMost));
  KERF_TRY(up, numberOf(words, 1, "UP", -kMost, kMost));
  KERF_TRY(in, numberOf(words, 2, "IN", -kMost, kMost));
  if (right != 0 || up != 0) c.bench.strokes->nudge(c.camera, right, up);
  // 0 along the axis alone: holds the present depth.
  if (in != 0 || (right == 0 && up == 0)) c.bench.strokes->moveAlong(in);
  return {};
}

Expected<void> pedal(AppContext& c, AppWords words) {
  const bool is_told = !words.empty() && (words[0] == "on" || words[0] == "off");
  if (!words.empty() && !is_told) return wrongWord("\"" + words[0] + "\"", "on or off");
  const bool goes_down = is_told ? words[0] == "on" : !c.bench.strokes->isOnPedal();
  if (!goes_down) {
    if (c.bench.strokes->isOnPedal()) c.bench.strokes->release();
    return {};
  }

  std::optional<Ray> at;
  if (words.size() > 1 || c.pointer) {
    KERF_TRY(ray, pointedRay(c, is_told ? words.subspan(1) : words));
    at = ray;
  }
  if (c.bench.strokes->stepOnPedal(at)) return {};
  return wrongWord("nothing to cut there", "a place on the object");
}

Expected<void> drill(AppContext& c, AppWords words) {
  KERF_TRY(percent, numberOf(words, 0, "PERCENT", 0, 100));
  c.bench.strokes->drill(0.01 * percent);
  return {};
}

Expected<void> pushHarder(AppContext& c, AppWords words) {
  KERF_TRY(factor, numberOf(words, 0, "FACTOR", 1, 10));
  c.bench.strokes->pushHarder(factor);
  return {};
}

Expected<void> reverse(AppContext& c, AppWords words) {
  if (words.empty()) return c.bench.strokes->setReversed(!c.bench.strokes->isReversed());
  if (words[0] != "on" && words[0] != "off") return wrongWord("\"" + words[0] + "\"", "on or off");
  return c.bench.strokes->setReversed(words[0] == "on");
}

Expected<void> setSpeed(AppContext& c, AppWords words) {
  KERF_TRY(percent, numberOf(words, 0, "PERCENT", 0, 100));
  c.bench.strokes->setSpeed(0.01 * percent);
  return {};
}

Expected<void> setIrrigation(AppContext& c, AppWords words) {
  KERF_TRY(percent, numberOf(words, 0, "PERCENT", 0, 100));
  c.bench.strokes->setIrrigation(0.01 * percent);
  return {};
}

Expected<void> setForce(AppContext& c, AppWords words) {
  KERF_TRY(force, numberOf(words, 0, "NEWTONS", Strokes::kLeastForce, Strokes::kMostForce));
  c.bench.strokes->setForce(force);
  return {};
}

Expected<void> setDepth(AppContext& c, AppWords words) {
  KERF_TRY(depth, numberOf(words, 0, "MM", 0, c.bench.strokes->mostDepth()));
  c.bench.strokes->deepen(depth - c.bench.strokes->depth_mm);
  return {};
}

Expected<void> deeper(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOr(words, 0, 0.1, "MM", 0, c.bench.strokes->mostDepth()));
  c.bench.strokes->deepen(mm);
  return {};
}

Expected<void> shallower(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOr(words, 0, 0.1, "MM", 0, c.bench.strokes->mostDepth()));
  c.bench.strokes->deepen(-mm);
  return {};
}

Expected<void> stopShort(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] == "off") {
    c.bench.strokes->stopShort(std::nullopt);
    return {};
  }
  KERF_TRY(mm, numberOr(words, 0, Strokes::kUsualShort, "MM", 0, Strokes::kMostShort));
  c.bench.strokes->stopShort(mm);
  return {};
}

Expected<void> press(AppContext& c, AppWords words) {
  KERF_TRY(ray, rayOf(c, words));
  if (c.bench.strokes->press(ray)) return {};
  return wrongWord(fmt::format("nothing to cut at {}, {}", words[0], words[1]), "a pixel of the object");
}

Expected<void> drag(AppContext& c, AppWords words) {
  KERF_TRY(ray, rayOf(c, words));
  c.bench.strokes->drag(ray);
  return {};
}

Expected<void> release(AppContext& c, AppWords) {
  c.bench.strokes->release();
  return {};
}

constexpr AppCommand kRows[] = {
    {"tool.tilt", "", "", "", "DEG [AZIMUTH]",
     "Tilts the tool from the surface normal by 0 to 75 degrees, the shank towards an azimuth in the view: 0 right, 90 "
     "up (default: the last azimuth, or up).",
     when::always, tilt},
    {"tool.tilt-reset", "Tool:1", "Reset tilt", "", "", "Sets the tool square to the surface.", isTilted, resetTilt},
    {"tool.hold-axis", "Tool:1", "Hold axis", "A", "[tool|view|occlusal|off]",
     "Keeps the tool's axis for all strokes, as of a path of insertion: the present one of the tool (default), of the "
     "view, or of the occlusal plane. Without a word the key holds and releases it.",
     when::isOpen, holdAxis},
    {"cut.force", "", "", "", "NEWTONS", "Sets the push force of a pressed button, 0.1 to 8 N.", when::always,
     setForce},
    {"cut.depth", "", "", "", "MM",
     "Sets the depth limit of a stroke below the original surface, 0 to 5 mm. A guided saw may go to the depth of its "
     "plane.",
     when::always, setDepth},
    {"cut.deeper", "Tool:2", "Increase depth", ".", "[MM]",
     "Increases the depth limit of a stroke (default: by 0.1 mm).", when::always, deeper},
    {"cut.shallower", "Tool:2", "Decrease depth", ",", "[MM]",
     "Decreases the depth limit of a stroke (default: by 0.1 mm).", when::always, shallower},
    {"cut.stop-short", "", "", "", "[MM|off]",
     "Stops strokes at this distance from pulp and nerve canal (default 0.5 mm).", when::always, stopShort},
    {"cut.press", "", "", "", "X Y", "Presses the button at a pixel: a stroke begins.", when::isOpen, press},
    {"cut.drag", "", "", "", "X Y", "Moves the pressed pointer to a pixel.", when::isOpen, drag},
    {"cut.release", "", "", "", "", "Releases the button: the stroke ends.", when::isOpen, release},
    {"cut.nudge", "", "", "", "RIGHT UP IN",
     "Moves a stroke, in mm: right and up over the surface as seen in the picture, and in along the tool axis down to "
     "the depth limit.",
     isCutting, nudge},
    {"cut.pedal", "Tool:2", "Press foot pedal", "Space", "[on|off] [X Y]",
     "Holds a stroke without the button: at a pixel, under the cursor or at the last cut. The key holds it while "
     "pressed.",
     when::isOpen, pedal},
    {"cut.drill", "", "", "", "PERCENT",
     "Sets the share of the spindle speed until the stroke ends, as a trigger does.", isCutting, drill},
    {"cut.push-harder", "", "", "", "FACTOR", "Multiplies the push, 1 to 10; 1 ends it.", when::always, pushHarder},
    {"cut.speed", "", "", "", "PERCENT", "Sets the spindle speed in percent of the nominal speed.", when::always,
     setSpeed},
    {"cut.reverse", "Tool:2", "Reverse drive", "T", "[on|off]",
     "Reverses the drive of a motor until the tool changes. Diamonds still cut; blades and drills only rub.",
     when::isOpen, reverse},
    {"cut.irrigation", "", "", "", "PERCENT", "Sets the irrigation, 0 to 100 % of full.", when::always, setIrrigation},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::stroke_commands
