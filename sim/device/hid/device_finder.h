// Lists the connected devices, and finds one by name.
#pragma once

#include <string>
#include <vector>

#include "sim/device/hid/device_driver.h"

namespace kerf {

/// A device that a driver matches, with all its interfaces that may talk; an arm has one.
struct FoundDevice {
  const DeviceDriver* driver = nullptr;
  std::string name;                 ///< of the model, for people
  std::vector<HidInfo> interfaces;  ///< at least one, by number

  const std::string& path() const { return interfaces.front().path; }
  const std::string& serial() const { return interfaces.front().serial; }
  bool mayOpen() const;  ///< all of them
  bool isArm() const { return driver->arm != nullptr; }
};

/// Groups the interfaces of each connected device, without those no driver knows. In the order of the paths.
std::vector<FoundDevice> groupDevices(const std::vector<HidInfo>& interfaces);
inline std::vector<FoundDevice> findDevices() { return groupDevices(listHid()); }

/// @param name  path of any of its interfaces, or its serial number. Empty: the only one.
/// Errors: kNotFound with a list of all; kBadValue: several and no name, or a serial that two of them have.
Expected<FoundDevice> chooseDevice(const std::vector<FoundDevice>& devices, const std::string& name);

}  // namespace kerf
