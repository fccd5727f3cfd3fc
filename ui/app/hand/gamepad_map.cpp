#include "ui/app/hand/gamepad_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

// Maps rest to full travel onto 0 to 1, continuous, quadratic near rest.
Eigen::Vector2d ofStick(const Eigen::Vector2d& stick) {
  const double size = stick.norm();
  if (!(size > GamepadLimits::kStickRest)) return Eigen::Vector2d::Zero();
  const double out = (std::min(size, 1.0) - GamepadLimits::kStickRest) / (1 - GamepadLimits::kStickRest);
  return out * out / size * stick;
}

double ofTrigger(double trigger) {
  return std::clamp((trigger - GamepadLimits::kTriggerRest) / (1 - GamepadLimits::kTriggerRest), 0.0, 1.0);
}

}  // namespace

GamepadWish wishOf(const GamepadState& now, const GamepadState& before, double seconds) {
  const double time = std::clamp(seconds, 0.0, GamepadLimits::kLongest);
  const double slowed = 1 - (1 - GamepadLimits::kSlow) * ofTrigger(now.left_trigger);
  const Eigen::Vector2d tool = GamepadLimits::kToolSpeed * time * slowed * ofStick(now.left_stick);

  GamepadWish out;
  out.tool_mm = {tool[0], -tool[1]};
  out.orbit = GamepadLimits::kOrbitSpeed * time * slowed * ofStick(now.right_stick);
  out.pedal = ofTrigger(now.right_trigger);
  out.undoes = now.a && !before.a;
  out.takes_previous = now.left_bumper && !before.left_bumper;
  out.takes_next = now.right_bumper && !before.right_bumper;
  return out;
}

Rumble rumbleOf(const HapticReport& report, double drive_share) {
  constexpr double kFine = 0.25;      // share of the fast motor at full speed in air
  constexpr double kHeavy = 3;        // N of contact for full power of the slow motor
  constexpr double kStanding = 0.05;  // share of the free speed; slower drives do not shake
  const double speed = std::min(std::abs(drive_share), 1.0);
  if (report.is_latched || !(speed > kStanding)) return {};
  const double contact = std::clamp(report.output.normal_load / kHeavy, 0.0, 1.0);
  return {contact * speed, std::min(1.0, kFine * speed + 0.5 * contact)};
}

void GamepadHand::update(AppContext& context, StrokePointer& pointer, const std::optional<GamepadState>& now,
                         double seconds) {
  const GamepadState state = now.value_or(GamepadState{});
  const GamepadWish wish = wishOf(state, std::exchange(before_, state), seconds);
  is_used_ = !wish.tool_mm.isZero(0) || !wish.orbit.isZero(0) || wish.pedal > 0;

  if (!wish.orbit.isZero(0)) {
    orbit(context.camera, wish.orbit[0], wish.orbit[1]);
    pointer.viewHasTurned(context);
  }
  if (!wish.tool_mm.isZero(0)) pointer.lead(context, wish.tool_mm);
  pedal_.update(context, pointer, wish.pedal);

  if (wish.undoes) runIfEnabled(context, "edit.undo");
  if (wish.takes_previous) runIfEnabled(context, "tool.previous");
  if (wish.takes_next) runIfEnabled(context, "tool.next");
}

}  // namespace kerf
