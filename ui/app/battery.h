// The battery of a wireless device, as its reports tell of it.
#pragma once

#include <optional>
#include <string>

#include "sim/device/device_driver.h"
#include "ui/app/language.h"

namespace kerf {

struct Battery {
  int percent = 0;
  bool is_charging = false;
};

/// None: the device has told of none.
inline std::optional<Battery> batteryOf(const DeviceReading& reading) {
  if (reading.battery_percent < 0) return {};
  return Battery{reading.battery_percent, reading.is_charging};
}

/// "35 %, charging".
inline std::string textOf(const Battery& battery) {
  return std::to_string(battery.percent) + shownText(battery.is_charging ? " %, charging" : " %");
}

}  // namespace kerf
