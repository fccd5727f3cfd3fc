// Gamepads whose reports are known to Kerf beyond their HID descriptor: how they are told to shake, what they say of
// their battery.
#pragma once

#include <optional>

#include "sim/device/hid_port.h"

namespace kerf {

enum class PadKind { kDualSense, kDualSenseBluetooth, kDualShock4, kDualShock4Bluetooth, kXboxBluetooth };

/// None: it is no such pad.
std::optional<PadKind> padKindOf(const HidInfo& info);
/// "DualSense by Bluetooth".
const char* nameOf(PadKind kind);

}  // namespace kerf
