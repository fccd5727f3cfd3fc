// What the haptic thread needs of a device: where the hand is, and somewhere to put the force.
#pragma once

#include "sim/step/device_sample.h"

namespace kerf {

/// All of it is called by the haptic thread: arm() once before the first read(), then read() and write() once a
/// tick, disarm() once after the last write(), which is zero. Before a pause (undo, no room) a zero is written at once,
/// without a read; until it ends, tenths of a second perhaps, nothing is.
///
/// None of it may allocate, throw or wait for anything that may take long. A driver whose transport can block has a
/// thread of its own and leaves the newest sample in a TripleBuffer; it says `is_valid = 0` when that has become old.
class DeviceSource {
 public:
  virtual ~DeviceSource() = default;
  virtual void arm() noexcept {}
  virtual DeviceSample read() noexcept = 0;
  virtual void write(const DeviceForce& force) noexcept = 0;
  virtual void disarm() noexcept {}
};

}  // namespace kerf
