// Looks for a device with axes until there is one, opens it, and begins anew when it is unplugged.
#pragma once

#include <memory>
#include <string>

#include "sim/device/hid_device.h"

namespace kerf {

/// A thread of its own lists devices, once a second as long as none is open.
class DeviceWatch {
 public:
  /// @param name  as chooseDevice(): of several without a name none is opened, and trouble() lists them.
  explicit DeviceWatch(std::string name = {}, int every_ms = 1000);
  ~DeviceWatch();
  DeviceWatch(const DeviceWatch&) = delete;
  DeviceWatch& operator=(const DeviceWatch&) = delete;

  /// The device that is open now; null: none. Who keeps it may go on asking it after it is unplugged. One thread, not
  /// the 1 kHz one.
  std::shared_ptr<HidDevice> device() const;
  /// What is wrong with a device that is there but does not open, one sentence; empty: nothing.
  std::string trouble() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
