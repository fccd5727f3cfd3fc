#include "ui/app/commands/hand_commands.h"

#include <numbers>
#include <optional>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"

namespace kerf::hand_commands {
namespace {

constexpr double kHandDegree = std::numbers::pi / 180;

}  // namespace

bool isTilted(const AppContext& c) { return !c.bench.tilt.isUpright(); }

Expected<void> tilt(AppContext& c, AppWords words) {
  constexpr double kUpwards = 90;
  const double before = isTilted(c) ? azimuthInView(c.camera, c.bench.tilt) / kHandDegree : kUpwards;
  KERF_TRY(angle, numberOf(words, 0, "DEG", 0, Tilt::kMost / kHandDegree));
  KERF_TRY(azimuth, numberOr(words, 1, before, "AZIMUTH", -360, 360));
  c.bench.tilt = tiltInView(c.camera, angle * kHandDegree, azimuth * kHandDegree);
  return {};
}

Expected<void> resetTilt(AppContext& c, AppWords) {
  c.bench.tilt = {};
  return {};
}

bool isCutting(const AppContext& c) { return c.bench.isPressed(); }

Expected<void> nudge(AppContext& c, AppWords words) {
  constexpr double kMost = 10;  // mm
  KERF_TRY(right, numberOf(words, 0, "RIGHT", -kMost, kMost));
  KERF_TRY(up, numberOf(words, 1, "UP", -kMost, kMost));
  KERF_TRY(in, numberOf(words, 2, "IN", -kMost, kMost));
  if (right != 0 || up != 0) c.bench.nudge(c.camera, right, up);
  if (in != 0) c.bench.moveAlong(in);
  return {};
}

Expected<void> pedal(AppContext& c, AppWords words) {
  const bool is_told = !words.empty() && (words[0] == "on" || words[0] == "off");
  if (!words.empty() && !is_told) return wrongWord("\"" + words[0] + "\"", "on or off");
  const bool goes_down = is_told ? words[0] == "on" : !c.bench.isOnPedal();
  if (!goes_down) {
    if (c.bench.isOnPedal()) c.bench.release();
    return {};
  }

  std::optional<Ray> at;
  if (words.size() > 1 || c.pointer) {
    KERF_TRY(ray, pointedRay(c, is_told ? words.subspan(1) : words));
    at = ray;
  }
  if (c.bench.stepOnPedal(at)) return {};
  return wrongWord("nothing to cut there", "a place on the object");
}

Expected<void> reverse(AppContext& c, AppWords words) {
  if (words.empty()) return c.bench.setReversed(!c.bench.isReversed());
  if (words[0] != "on" && words[0] != "off") return wrongWord("\"" + words[0] + "\"", "on or off");
  return c.bench.setReversed(words[0] == "on");
}

Expected<void> setSpeed(AppContext& c, AppWords words) {
  KERF_TRY(percent, numberOf(words, 0, "PERCENT", 0, 100));
  c.bench.setSpeed(0.01 * percent);
  return {};
}

Expected<void> setIrrigation(AppContext& c, AppWords words) {
  KERF_TRY(percent, numberOf(words, 0, "PERCENT", 0, 100));
  c.bench.setIrrigation(0.01 * percent);
  return {};
}

}  // namespace kerf::hand_commands
