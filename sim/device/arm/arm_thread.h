// Common part of every arm transport: a thread that waits for the device, and its published data.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "sim/device/arm/force_arm.h"

namespace kerf::internal {

/// @thread  start() and stop(): the owner. `counts`: any thread, while it holds `mutex`.
class ArmThread {
 public:
  /// @param run  must end soon after isStopping().   @param file, place  of the error.
  /// Error kBadValue: the system gives no thread.
  Expected<void> start(std::function<void()> run, std::string file, std::string place);
  bool isStopping() const noexcept { return is_stopping_.load(std::memory_order_acquire); }
  /// Waits until the thread has ended.
  void stop();

  /// A copy, with is_talking by the age of the newest hand.
  ArmCounts told() const;

  /// The arm's; set before start().
  ArmListener listener;
  /// @thread  the arm's, without `mutex`.
  void tell(std::int64_t came_ns, std::span<const std::uint8_t> message) const {
    if (listener && !message.empty()) listener(came_ns, message);
  }

  mutable std::mutex mutex;
  ArmCounts counts;  ///< guarded by mutex

 private:
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

}  // namespace kerf::internal
