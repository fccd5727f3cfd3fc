// Searches for a device with axes, opens it, and searches again when it is unplugged.
#pragma once

#include <memory>
#include <string>

#include "sim/device/hid/hid_device.h"

namespace kerf {

/// A thread of its own lists devices once a second while none is open.
class DeviceWatch {
 public:
  /// @param name  as in chooseDevice(): of several without a name none is opened, and trouble() lists them.
  explicit DeviceWatch(std::string name = {}, int every_ms = 1000);
  ~DeviceWatch();
  DeviceWatch(const DeviceWatch&) = delete;
  DeviceWatch& operator=(const DeviceWatch&) = delete;

  /// The open device; null: none. A caller may keep and read it after it is unplugged. One thread, not the 1 kHz one.
  std::shared_ptr<HidDevice> device() const;
  /// Fault of a device that is present but does not open, one sentence; empty: none.
  std::string trouble() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
