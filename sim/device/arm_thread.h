// What every transport of an arm has: a thread of its own that waits for the device, and what that thread tells others.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "sim/device/force_arm.h"

namespace kerf::internal {

/// @thread  start() and stop(): who owns it. Of `counts` any thread, while it holds `mutex`.
class ArmThread {
 public:
  /// @param run  ends soon after isStopping().   @param file, place  of the error.
  /// Error kBadValue: the system gives no thread.
  Expected<void> start(std::function<void()> run, std::string file, std::string place);
  bool isStopping() const noexcept { return is_stopping_.load(std::memory_order_acquire); }
  /// Waits until it has ended.
  void stop();

  /// A copy, with is_talking by the age of the newest hand.
  ArmCounts told() const;

  /// Of the arm, set before start().
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
