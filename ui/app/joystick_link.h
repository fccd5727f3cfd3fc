// A joystick that is no gamepad for GLFW, read by its HID descriptor: it leads the tool as a gamepad does.
//
//   stick               leads the tool over the surface        twist, hat   turns the view
//   button 1, trigger   drills                                 button 2     takes back a stroke
//   buttons 3, 4        take the tool before, the next one
//
// Force feedback of the class PID, EXPERIMENTAL and only where a person asks for it: while it drills the stick is
// damped by the contact and shaken by the drive. It is never pushed: a stick that leads by rate and is pushed away
// leads the tool on by itself, the force that a share of its largest one is is not known, and an effect goes on for up
// to a tenth of a second after the last word, not 20 ms.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "sim/device/device_driver.h"
#include "sim/device/pid_device.h"
#include "sim/device/rumble_pad.h"
#include "ui/app/gamepad_map.h"

namespace kerf {

/// What the axes and buttons of a joystick mean for a gamepad.
GamepadState gamepadStateOf(const DeviceReading& reading);
/// What it is told while a gamepad would shake so.
PidWish pidWishOf(const Rumble& rumble);

/// One thread, the window's. A thread of its own lists devices once a second as long as none is open.
class JoystickLink {
 public:
  /// @param gives_force  it may be damped and shaken.
  explicit JoystickLink(bool gives_force = false);
  ~JoystickLink();
  JoystickLink(const JoystickLink&) = delete;
  JoystickLink& operator=(const JoystickLink&) = delete;

  /// Its newest state; none: no joystick is open.
  std::optional<GamepadState> read();
  /// What has changed since the last call, a sentence for a notice: it was found, or is gone.
  std::optional<std::string> news();
  /// Of the one that was read last; empty: there is none.
  std::string name() const;
  /// What is wrong with one that is there but does not open; empty: nothing. No news: not every joystick is for this.
  std::string trouble() const;
  /// Whether it can be damped and shaken, or why not.
  std::string force() const;
  /// Once a frame; zero: at rest. Opens it for its effects when there is something to be felt first.
  void shake(const Rumble& wanted);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
