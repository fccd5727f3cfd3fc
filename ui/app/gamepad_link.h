// What the window tells of its gamepad beyond sticks and buttons, which GLFW reads: whether it can shake, and its
// battery. Looked for as long as somebody wants to know. No GLFW.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ui/app/battery.h"
#include "ui/app/pad_rumble.h"

namespace kerf {

struct GamepadDetails {
  bool can_shake = false;
  std::string shake;               ///< "DualSense: shakes while it drills", or why it does not
  std::optional<Battery> battery;  ///< none: it has told of none
};

/// One thread, the window's. A thread of its own lists devices once a second as long as the pad is not open.
class GamepadLink {
 public:
  GamepadLink();
  ~GamepadLink();
  GamepadLink(const GamepadLink&) = delete;
  GamepadLink& operator=(const GamepadLink&) = delete;

  /// @param pad  in use, as GLFW names it; none: there is none, or nobody wants to know.
  GamepadDetails update(const std::optional<PadId>& pad);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
