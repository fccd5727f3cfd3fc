// Texts and JSON of `kerf devices` for connected devices and their input.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "sim/device/frame/device_frame.h"
#include "sim/device/hid/device_finder.h"

namespace kerf::cli {

inline constexpr const char* kMayNotOpen =
    "no permission to open it: run scripts/setup --udev (udev rule 70-kerf-hid.rules), then unplug the device and plug "
    "it in again";

/// "046d:c626".
std::string idOf(const HidInfo& info);
nlohmann::json jsonOf(const FoundDevice& found);

/// @param axes  after settings.
std::string textOf(const DeviceReading& reading, const std::array<double, 6>& axes);
nlohmann::json jsonOf(const DeviceReading& reading, const std::array<double, 6>& axes);

/// @param velocity  mm/s.
std::string textOf(const HandFrame& hand, const Vec3d& velocity);
nlohmann::json jsonOf(const HandFrame& hand, const Vec3d& velocity);

/// Speed of a hand: as reported by the device, else from positions over 50 ms, since those over one millisecond are
/// encoder steps.
class HandSpeed {
 public:
  /// @return  mm/s.
  Vec3d at(std::int64_t time_us, const HandFrame& hand);

 private:
  struct Place {
    std::int64_t time_us = -1;  // negative: none yet
    Vec3d position = Vec3d::Zero();
  };
  Place from_, next_;
};

}  // namespace kerf::cli
