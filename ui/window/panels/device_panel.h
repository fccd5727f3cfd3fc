// The device panel: the force-feedback arm live, with its limits and missing parts; the SpaceMouse, and the gamepad or
// joystick.
#pragma once

#include <optional>
#include <string>

#include "ui/app/base/battery.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/hand/gamepad_map.h"
#include "ui/app/hand/space_mouse_map.h"

namespace kerf {

/// State of the SpaceMouse, and of the gamepad or joystick.
struct DevicePanelState {
  std::optional<SpaceMouseState> knob{};  ///< none: not connected
  std::string knob_name{}, knob_trouble{};
  std::optional<Battery> knob_battery{};  ///< none: not reported

  std::optional<GamepadState> pad{};  ///< none: neither gamepad nor joystick
  std::string pad_name{};
  bool is_joystick = false, can_pad_shake = false;
};

/// Draws nothing while hidden: device.panel.
void drawDevicePanel(AppContext& context, const DevicePanelState& state);

}  // namespace kerf
