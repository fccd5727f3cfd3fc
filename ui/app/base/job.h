// Long work beside the window: own thread, progress, time left, cancel.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf {

struct JobStatus {
  std::string title;             ///< "Preparing molar.stl"
  std::string step;              ///< current step, named by the work
  double done = 0;               ///< 0 to 1
  double seconds = 0;            ///< since the start
  std::optional<double> left_s;  ///< extrapolated; none in the first second
  bool is_cancelling = false;
  bool can_be_cancelled = true;
};

/// The window's view of a job.
class AnyJob {
 public:
  virtual ~AnyJob() = default;
  virtual JobStatus status() const = 0;
  virtual void cancel() = 0;  ///< the work stops at its next report of progress
  virtual bool isOver() const = 0;
};

/// Runs `work` once, on its own thread. Call the members from the window thread only.
template <class T>
class Job final : public AnyJob {
 public:
  using Work = std::function<Expected<T>(const Progress&)>;

  Job(std::string title, Work work, bool can_be_cancelled = true)
      : title_(std::move(title)), can_be_cancelled_(can_be_cancelled) {
    thread_ = std::thread([this, work = std::move(work)] {
      result_.emplace(guarded(work));
      is_over_.store(true, std::memory_order_release);
    });
  }
  /// Cancels and waits.
  ~Job() override {
    cancel();
    if (thread_.joinable()) thread_.join();
  }
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  JobStatus status() const override {
    JobStatus out;
    out.title = title_;
    out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
    out.is_cancelling = is_cancelled_.load();
    out.can_be_cancelled = can_be_cancelled_;
    const std::lock_guard lock(mutex_);
    out.step = step_;
    out.done = done_;
    if (out.seconds > 1 && done_ > 0.02) out.left_s = out.seconds * (1 - done_) / done_;
    return out;
  }
  void cancel() override { is_cancelled_.store(true); }
  bool isOver() const override { return is_over_.load(std::memory_order_acquire); }

  /// Waits for the end and returns the result. Call once.
  Expected<T> take() {
    if (thread_.joinable()) thread_.join();
    return std::move(*result_);
  }

 private:
  // Turns exceptions of the work into errors, most often out of memory.
  Expected<T> guarded(const Work& work) {
    try {
      return work([this](double done, std::string_view step) {
        const std::lock_guard lock(mutex_);
        done_ = done;
        step_ = step;
        return !is_cancelled_.load();
      });
    } catch (const std::bad_alloc&) {
      return fail({.code = Error::Code::kUnsupported,
                   .place = title_,
                   .found = "not enough memory",
                   .expected = "more free memory",
                   .hint = "use larger voxels, or close other programs"});
    } catch (const std::exception& e) {
      return fail({.code = Error::Code::kUnsupported, .place = title_, .found = e.what()});
    }
  }

  const std::string title_;
  const bool can_be_cancelled_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::atomic<bool> is_cancelled_{false}, is_over_{false};
  mutable std::mutex mutex_;
  std::string step_;  // guarded by mutex_
  double done_ = 0;   // guarded by mutex_
  std::optional<Expected<T>> result_;
  std::thread thread_;
};

}  // namespace kerf
