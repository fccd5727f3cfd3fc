// The panel about devices: the force-feedback arm, live, with what bounds it and what is missing; the SpaceMouse.
#pragma once

#include <optional>
#include <string>

#include "ui/app/app_commands.h"
#include "ui/app/battery.h"
#include "ui/app/gamepad_map.h"
#include "ui/app/space_mouse_map.h"

namespace kerf {

/// What the window knows of its SpaceMouse, and of what leads as a gamepad does.
struct DevicePanelState {
  std::optional<SpaceMouseState> knob{};  ///< none: there is none
  std::string knob_name{}, knob_trouble{};
  std::optional<Battery> knob_battery{};  ///< none: it has told of none

  std::optional<GamepadState> pad{};  ///< none: neither gamepad nor joystick
  std::string pad_name{}, pad_trouble{};
  std::string pad_shakes{};  ///< that it does, or why not
  bool can_pad_shake = false, is_joystick = false;
  std::optional<Battery> pad_battery{};
};

/// Nothing if it is not shown: device.panel.
void drawDevicePanel(AppContext& context, const DevicePanelState& state);

}  // namespace kerf
