// The panel about devices: the force-feedback arm, live, with what bounds it and what is missing; the SpaceMouse.
#pragma once

#include <optional>
#include <string>

#include "ui/app/app_commands.h"
#include "ui/app/space_mouse_map.h"

namespace kerf {

/// What the window knows of its SpaceMouse.
struct DevicePanelState {
  std::optional<SpaceMouseState> knob{};  ///< none: there is none
  std::string knob_name{}, knob_trouble{};
};

/// Nothing if it is not shown: device.panel.
void drawDevicePanel(AppContext& context, const DevicePanelState& state);

}  // namespace kerf
