// A gamepad as a handpiece: meaning of its sticks, triggers and buttons.
//
//   left stick     leads the tool over the surface, in the picture   right stick   turns the view
//   right trigger  drills: its travel is the pedal                   left trigger  slows both sticks, to a fifth
//   A              undoes a stroke                                   bumpers       previous and next tool
//
// It shakes while drilling: fine for the drive, heavy for contact.
//
// Independent of SDL: takes states, calls the workbench.
#pragma once

#include <optional>

#include "sim/live/haptic_thread.h"
#include "ui/app/hand/pedal_hold.h"

namespace kerf {

/// State of a gamepad.
struct GamepadState {
  Eigen::Vector2d left_stick = Eigen::Vector2d::Zero();   ///< -1 to 1: right, down
  Eigen::Vector2d right_stick = Eigen::Vector2d::Zero();  ///< as left_stick
  double left_trigger = 0, right_trigger = 0;             ///< 0 (at rest) to 1
  bool a = false, left_bumper = false, right_bumper = false;
};

/// Actions for the time since the previous state.
struct GamepadWish {
  Eigen::Vector2d tool_mm = Eigen::Vector2d::Zero();                ///< right, up, in the picture
  Eigen::Vector2d orbit = Eigen::Vector2d::Zero();                  ///< pixels, as orbit() takes them
  double pedal = 0;                                                 ///< 0 (trigger at rest) to 1
  bool undoes = false, takes_next = false, takes_previous = false;  ///< the button was just pressed
};

struct GamepadLimits {
  static constexpr double kStickRest = 0.15;   ///< a stick closer to its middle is at rest
  static constexpr double kTriggerRest = 0.1;  ///< a trigger pulled less is at rest
  static constexpr double kSlow = 0.2;         ///< speed factor with the left trigger fully pulled
  static constexpr double kToolSpeed = 8;      ///< mm/s, sideways limit of MouseHand
  static constexpr double kOrbitSpeed = 240;   ///< pixels/s: 120 degrees a second
  static constexpr double kLongest = 0.1;      ///< s, so that a slow frame causes no jump
};

/// @param seconds  since `before`.
GamepadWish wishOf(const GamepadState& now, const GamepadState& before, double seconds);

struct Rumble {
  double strong = 0, weak = 0;  ///< 0 to 1: the slow heavy motor, the fast light motor
  bool operator==(const Rumble&) const = default;
};
/// @param drive_share  speed of the drive over its free speed, -1 to 1.
Rumble rumbleOf(const HapticReport& report, double drive_share);

/// Call update() once a frame.
class GamepadHand {
 public:
  /// @param now  none: no gamepad, or its input is not for this window; this ends its stroke.
  void update(AppContext& context, StrokePointer& pointer, const std::optional<GamepadState>& now, double seconds);
  /// The last update() had an effect.
  bool isUsed() const { return is_used_; }

 private:
  GamepadState before_;
  PedalHold pedal_;
  bool is_used_ = false;
};

}  // namespace kerf
