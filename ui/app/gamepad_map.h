// A gamepad as a handpiece: what its sticks, triggers and buttons mean.
//
//   left stick     leads the tool over the surface, in the picture   right stick   turns the view
//   right trigger  drills: how far it is pulled is the pedal         left trigger  slows both sticks, to a fifth
//   A              takes back a stroke                               bumpers       previous and next tool
//
// While it drills it shakes: the drive as a fine trembling, contact as a heavy one.
//
// No SDL: states in, calls of the workbench out.
#pragma once

#include <optional>

#include "sim/live/haptic_thread.h"
#include "ui/app/pedal_hold.h"

namespace kerf {

/// What a gamepad reports.
struct GamepadState {
  Eigen::Vector2d left_stick = Eigen::Vector2d::Zero();   ///< -1 to 1: right, down
  Eigen::Vector2d right_stick = Eigen::Vector2d::Zero();  ///< the same
  double left_trigger = 0, right_trigger = 0;             ///< 0, at rest, to 1
  bool a = false, left_bumper = false, right_bumper = false;
};

/// What that means for the time since the state before.
struct GamepadWish {
  Eigen::Vector2d tool_mm = Eigen::Vector2d::Zero();                ///< right, up, in the picture
  Eigen::Vector2d orbit = Eigen::Vector2d::Zero();                  ///< pixels, as orbit() takes them
  double pedal = 0;                                                 ///< 0: the trigger is at rest; to 1
  bool undoes = false, takes_next = false, takes_previous = false;  ///< the button has just gone down
};

struct GamepadLimits {
  static constexpr double kStickRest = 0.15;   ///< nearer to its middle a stick is at rest
  static constexpr double kTriggerRest = 0.1;  ///< so far a trigger may be pulled at rest
  static constexpr double kSlow = 0.2;         ///< times the speed, left trigger pulled all the way
  static constexpr double kToolSpeed = 8;      ///< mm/s: as fast as the hand follows
  static constexpr double kOrbitSpeed = 240;   ///< pixels/s: 120 degrees a second
  static constexpr double kLongest = 0.1;      ///< s: a slow frame makes no leap
};

/// @param seconds  since `before`.
GamepadWish wishOf(const GamepadState& now, const GamepadState& before, double seconds);

struct Rumble {
  double strong = 0, weak = 0;  ///< 0 to 1: the slow heavy motor, the fast light one
  bool operator==(const Rumble&) const = default;
};
/// @param drive_share  speed of the drive over its free speed, -1 to 1.
Rumble rumbleOf(const HapticReport& report, double drive_share);

/// Once a frame.
class GamepadHand {
 public:
  /// @param now  none: no gamepad, or it is not for this window. A stroke that it holds ends.
  void update(AppContext& context, StrokePointer& pointer, const std::optional<GamepadState>& now, double seconds);
  /// It did something in the last update().
  bool isUsed() const { return is_used_; }

 private:
  GamepadState before_;
  PedalHold pedal_;
  bool is_used_ = false;
};

}  // namespace kerf
