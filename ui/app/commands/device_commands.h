// State of the force-feedback device for scripts. The commands device.* are in device_commands.cpp.
#pragma once

#include <string>

#include "ui/app/commands/app_commands.h"

namespace kerf::device_commands {

/// The device of the window as one JSON object.
std::string deviceState(const AppContext& c);

}  // namespace kerf::device_commands
