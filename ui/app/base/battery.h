// Battery state from the reports of a wireless device.
#pragma once

#include <optional>
#include <string>

#include "sim/device/hid/device_driver.h"
#include "ui/app/base/language.h"

namespace kerf {

struct Battery {
  int percent = 0;
  bool is_charging = false;
};

/// None if the device reports no battery.
inline std::optional<Battery> batteryOf(const DeviceReading& reading) {
  if (reading.battery_percent < 0) return {};
  return Battery{reading.battery_percent, reading.is_charging};
}

/// "35 %, charging".
inline std::string textOf(const Battery& battery) {
  return std::to_string(battery.percent) + shownText(battery.is_charging ? " %, charging" : " %");
}

}  // namespace kerf
