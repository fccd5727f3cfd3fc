// A haptic thread for test machines, a device that detects allocations, and functions that wait for the thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>

#include "sim/live/haptic_thread.h"
#include "tests/support/allocation_guard.h"

namespace kerf::test {

// Without a priority that starves others and without locked memory. The machine may be too busy to run a thread for a
// while.
inline HapticOptions ordinaryHaptics() {
  HapticOptions options;
  options.real_time = {.priority = 0, .lock_memory = false};
  options.stall_ms = 5000;
  return options;
}

// Under an AllocationGuard from the first tick to the last: an allocation in a tick ends the test.
class GuardedDevice : public DeviceSource {
 public:
  explicit GuardedDevice(DeviceSource* inner = nullptr) : inner_(inner) {}
  void arm() noexcept override {
    if (inner_) inner_->read();  // a virtual hand allocates its delay line
    guard_.emplace();
    is_armed = true;
  }
  DeviceSample read() noexcept override {
    ++reads;
    return inner_ ? inner_->read() : sample;
  }
  void write(const DeviceForce& force) noexcept override {
    if (inner_) inner_->write(force);
    last_force = force.force.norm();
    most_force = std::max(most_force, last_force);
  }
  void disarm() noexcept override {
    is_disarmed = true;
    guard_.reset();
  }
  std::atomic<std::uint64_t> reads{0};
  DeviceSample sample;  // without an inner device
  double last_force = -1, most_force = 0;
  bool is_armed = false, is_disarmed = false;

 private:
  DeviceSource* inner_;
  std::optional<AllocationGuard> guard_;
};

// Waits up to a minute for a report of the haptic thread.
inline bool becomes(HapticThread& haptic, const std::function<bool(const HapticReport&)>& holds) {
  for (int n = 0; n < 60'000; ++n) {
    haptic.update();
    if (holds(haptic.report())) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace kerf::test
