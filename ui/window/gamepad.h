// Reads a gamepad through GLFW.
#pragma once

#include <optional>
#include <string>

#include "ui/app/gamepad_map.h"
#include "ui/app/pad_rumble.h"

namespace kerf {

/// The first one that GLFW has a mapping for; none: none is plugged in. The window's thread.
std::optional<GamepadState> readGamepad();

/// Which one that is.
std::optional<PadId> gamepadId();
/// Its name, as GLFW's mappings call it; empty: there is none.
std::string gamepadName();

}  // namespace kerf
