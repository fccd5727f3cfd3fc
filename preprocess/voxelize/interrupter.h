// Cancellation for OpenVDB's long loops.
#pragma once

#include <atomic>
#include <chrono>
#include <string_view>
#include <thread>

#include "geometry/base/progress.h"

namespace kerf::internal {

/// Forwards cancellation into the library's long loops, which poll from all threads. Only the constructing thread calls
/// the progress callback. It takes part in every loop, so it learns of a cancellation in time.
class Interrupter {
 public:
  explicit Interrupter(const Progress& progress) : progress_(progress) {}

  /// Names the next step; returns true to continue.
  bool step(double fraction, std::string_view what) {
    fraction_ = fraction;
    what_ = what;
    ask();
    return !cancelled_;
  }
  bool isCancelled() const { return cancelled_; }

  // Interface for the library.
  void start(const char* = nullptr) {}
  void end() {}
  bool wasInterrupted(int = -1) {
    if (std::this_thread::get_id() == caller_ && std::chrono::steady_clock::now() >= next_question_) ask();
    return cancelled_.load(std::memory_order_relaxed);
  }

 private:
  void ask() {
    if (!report(progress_, fraction_, what_)) cancelled_ = true;
    next_question_ = std::chrono::steady_clock::now() + std::chrono::milliseconds(50);
  }
  std::atomic<bool> cancelled_{false};
  const Progress& progress_;
  double fraction_ = 0;
  std::string_view what_{};
  std::thread::id caller_ = std::this_thread::get_id();
  std::chrono::steady_clock::time_point next_question_{};
};

}  // namespace kerf::internal
