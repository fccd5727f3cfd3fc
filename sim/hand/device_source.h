// The haptic thread's interface to a device: pose of the hand in, force out.
#pragma once

#include "sim/step/device_sample.h"

namespace kerf {

/// The haptic thread calls all of it: arm() once before the first read(), then read() and write() once a tick, placed()
/// between ticks, disarm() once after the last write(), which is zero. Before a pause (undo, no memory for bricks) it
/// writes a zero at once, without a read. Until the pause ends, perhaps tenths of a second later, it writes nothing.
///
/// No function may allocate, throw or wait long. A driver whose transport can block has a thread of its own and leaves
/// the newest sample in a TripleBuffer. It sets `is_valid = 0` when that has become old.
class DeviceSource {
 public:
  virtual ~DeviceSource() = default;
  virtual void arm() noexcept {}
  virtual DeviceSample read() noexcept = 0;
  virtual void write(const DeviceForce& force) noexcept = 0;
  /// PlaceTool put the tool at this pose. A device without a place of its own in the room follows: its next sample is
  /// that pose. Other devices may ignore it.
  virtual void placed(const Rigid3& /*T_world_tool*/) noexcept {}
  virtual void disarm() noexcept {}
  /// Nobody moves or feels this device, as of the last read(): its ticks may come in bursts. What ends that also sends
  /// a command.
  virtual bool isAtRest() const noexcept { return false; }
};

}  // namespace kerf
