// Finds, opens, reads and shakes the gamepad or joystick of the window through SDL. Joystick controls:
//
//   stick               leads the tool over the surface        twist, hat   turns the view
//   button 1, trigger   drills                                 button 2     undoes a stroke
//   buttons 3, 4        previous and next tool
//
// Twist is the first axis beyond the stick that is near its middle at opening; a throttle seldom is. Only gamepads
// shake, because the system lists a wheel with strong motors as a joystick.
//
// SDL reads the kernel's event nodes (hidapi is for the SpaceMouse), so the kernel stops the motors of a killed
// program. SDL ends a shake() only during calls of read(): if the program hangs, the motors run on for up to 65 s.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ui/app/hand/gamepad_map.h"

namespace kerf {

/// Window thread only. One object at a time, because SDL's state is global.
class GameController {
 public:
  static constexpr double kShakeSeconds = 0.2;  ///< duration of one shake()

  GameController();
  ~GameController();
  GameController(const GameController&) = delete;
  GameController& operator=(const GameController&) = delete;

  /// Call once a frame: looks for devices and reads the first gamepad, else the first joystick. None: neither is
  /// plugged in.
  std::optional<GamepadState> read();
  /// A notice since the last call: a device was opened or unplugged, a device failed to open, or SDL failed to start.
  std::optional<std::string> news();
  /// SDL's name of the open device; empty: none.
  const std::string& name() const noexcept;
  bool isJoystick() const noexcept;
  bool canShake() const noexcept;
  /// Shakes the gamepad for kShakeSeconds; zero stops it. Repeat each frame while drilling.
  void shake(const Rumble& wanted);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
