// The gamepad or joystick of the window, through SDL: found, opened, read, shaken. A joystick leads as a gamepad does:
//
//   stick               leads the tool over the surface        twist, hat   turns the view
//   button 1, trigger   drills                                 button 2     takes back a stroke
//   buttons 3, 4        take the tool before, the next one
//
// Twist is the first axis beyond the stick that is near its middle when the joystick is opened: a throttle seldom is.
// Gamepads alone are shaken: a wheel with strong motors is a joystick for the system.
//
// SDL reads the event nodes of the kernel (hidapi is for the SpaceMouse), so the kernel stops the motors of a program
// that was killed. SDL ends a shake() by itself, but only while read() is called: the motors of a program that hangs
// run on for up to 65 s.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ui/app/gamepad_map.h"

namespace kerf {

/// One thread, the window's. One object at a time: SDL is the whole process's.
class GameController {
 public:
  static constexpr double kShakeSeconds = 0.2;  ///< of one shake()

  GameController();
  ~GameController();
  GameController(const GameController&) = delete;
  GameController& operator=(const GameController&) = delete;

  /// Once a frame: looks for devices, reads the open one. The first gamepad leads, else the first joystick; none:
  /// neither is plugged in.
  std::optional<GamepadState> read();
  /// A sentence for a notice since the last call: a device was opened or unplugged, a device cannot be opened, or SDL
  /// does not start.
  std::optional<std::string> news();
  /// The open device as SDL names it; empty: none.
  const std::string& name() const noexcept;
  bool isJoystick() const noexcept;
  bool canShake() const noexcept;
  /// Shakes the gamepad for kShakeSeconds; zero: stops it. Each frame again while it drills.
  void shake(const Rumble& wanted);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
