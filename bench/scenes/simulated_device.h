// A virtual hand as the device of the haptic thread, for tests and measurements.
#pragma once

#include <atomic>

#include "sim/hand/device_source.h"
#include "sim/hand/virtual_hand.h"

namespace kerf {

/// Moves as its hand does, one tick per read(), and feels the force of the last tick. At the end of the path it stays
/// there and lifts the pedal. For hands that use the force alone: DeviceHand and FeedHand. A ForceHand watches the
/// tool, which a device cannot see.
class SimulatedDevice final : public DeviceSource {
 public:
  /// @param hand  kept by reference.
  explicit SimulatedDevice(VirtualHand& hand) : hand_(hand) {}
  DeviceSample read() noexcept override {
    if (!is_over_.load(std::memory_order_relaxed) && !hand_.next(last_, sample_)) {
      sample_.pedal = 0;
      is_over_.store(true, std::memory_order_release);
    }
    return sample_;
  }
  void write(const DeviceForce& force) noexcept override { last_.force = force; }
  /// Any thread: the path is complete.
  bool isOver() const noexcept { return is_over_.load(std::memory_order_acquire); }

 private:
  VirtualHand& hand_;
  StepOutput last_;
  DeviceSample sample_;
  std::atomic<bool> is_over_{false};
};

}  // namespace kerf
