// What the haptic thread needs of a device: where the hand is, and somewhere to put the force.
#pragma once

#include "sim/step/device_sample.h"

namespace kerf {

/// The haptic thread calls all of it: arm() once before the first read(), then read() and write() once a tick, placed()
/// between ticks, disarm() once after the last write(), which is zero. Before a pause (undo, no memory for bricks) a
/// zero is written at once, without a read. Until the pause ends, perhaps tenths of a second later, nothing is written.
///
/// None of it may allocate, throw or wait for anything that may take long. A driver whose transport can block has a
/// thread of its own and leaves the newest sample in a TripleBuffer; it says `is_valid = 0` when that has become old.
class DeviceSource {
 public:
  virtual ~DeviceSource() = default;
  virtual void arm() noexcept {}
  virtual DeviceSample read() noexcept = 0;
  virtual void write(const DeviceForce& force) noexcept = 0;
  /// The tool was put there by PlaceTool. A device without a place of its own in the room follows: its next sample is
  /// that pose. Other devices need not listen.
  virtual void placed(const Rigid3& /*T_world_tool*/) noexcept {}
  virtual void disarm() noexcept {}
};

}  // namespace kerf
