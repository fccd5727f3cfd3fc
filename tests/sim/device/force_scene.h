// Shared by tests of force devices: waiting, a replacement of the haptic thread, a simulated system.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <mutex>
#include <thread>

#include "sim/device/hid/device_driver.h"
#include "sim/device/record/arm_opener.h"
#include "tests/support/hid_testbed.h"

namespace kerf::test {

template <class Condition>
bool until(const Condition& holds, int most_ms = 20000) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(most_ms);
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  return holds();
}
// A process that repeats an action until it is killed as by kill -9.
class Doomed {
 public:
  /// @param begin  returns the action of each millisecond, which owns its data.
  explicit Doomed(const std::function<std::function<void()>()>& begin) : process_(::fork()) {
    if (process_ != 0) return;
    const std::function<void()> each = begin();
    for (;;) {
      if (!each) ::_exit(1);
      each();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  ~Doomed() { kill(); }
  Doomed(const Doomed&) = delete;
  Doomed& operator=(const Doomed&) = delete;
  pid_t process() const { return process_; }
  void kill() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    process_ = 0;
  }

 private:
  pid_t process_;
};

// Replaces the haptic thread with a constant force.
class Pusher {
 public:
  Pusher(ForceArm& arm, const Vec3d& force) : arm_(arm), force_(force) {
    thread_ = std::thread([this] { run(); });
  }
  ~Pusher() {
    is_stopping_ = true;
    thread_.join();
  }
  std::atomic<bool> hangs{false}, is_valid{false}, gives_nan{false};
  /// Waits until no hand is valid.   @return  age of the newest hand when it was last taken, ms, by the taker's clock,
  /// independent of machine load.
  double lastTakenAgeMs() const {
    EXPECT_TRUE(until([&] { return !is_valid; }));
    return 1e-6 * static_cast<double>(taken_ns_ - arm_.counts().newest_came_ns);
  }
  Vec3d place() const {
    const std::lock_guard lock(mutex_);
    return place_;
  }

 private:
  void run() {
    arm_.arm();
    while (!is_stopping_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (hangs) continue;
      const std::int64_t now = deviceClock();
      const DeviceSample sample = arm_.read();
      if (sample.is_valid) taken_ns_ = now;
      is_valid = sample.is_valid != 0;
      {
        const std::lock_guard lock(mutex_);
        place_ = sample.T_world_device.translation;
      }
      const Vec3d force = gives_nan ? Vec3d::Constant(std::numeric_limits<double>::quiet_NaN()) : force_;
      arm_.write({sample.is_valid ? force : Vec3d(Vec3d::Zero()), Vec3d::Zero()});
    }
    arm_.disarm();
  }
  ForceArm& arm_;
  const Vec3d force_;
  std::atomic<bool> is_stopping_{false};
  std::atomic<std::int64_t> taken_ns_{0};
  mutable std::mutex mutex_;
  Vec3d place_ = Vec3d::Zero();
  std::thread thread_;
};

// Under the system's hidapi; skipped where umockdev is not preloaded.
class OnTestbed : public testing::Test {
 protected:
  void SetUp() override {
    if (!HidTestbed::isThere()) GTEST_SKIP() << "umockdev is not preloaded: run umockdev-wrapper kerf_device_tests";
    bed_ = std::make_unique<HidTestbed>();
  }
  std::unique_ptr<ForceArm> open(const std::string& name = HidTestbed::path(0)) {
    auto opened = openArm(name, {.limits = {.force = 3, .rate = 500, .ramp_s = 0.1}});
    EXPECT_TRUE(opened) << opened.error().message();
    return opened ? std::move(opened->arm) : nullptr;
  }
  Bytes lastWritten() const { return bed_->lastWritten(0); }
  // Makes a change that ends the force, and waits for the end. Kerf sends at most one force per millisecond, so the
  // number of reports with force is a time in ms, independent of machine load.
  int forcesAfter(const std::function<void()>& change, const std::function<bool(const Bytes&)>& gives) {
    const std::size_t before = bed_->written(0).size();
    change();
    EXPECT_TRUE(until([&] { return !gives(lastWritten()); }));
    const std::vector<Bytes> all = bed_->written(0);
    return static_cast<int>(std::count_if(all.begin() + static_cast<std::ptrdiff_t>(before), all.end(), gives));
  }
  static constexpr int kDeadMan = 25;  ///< reports: 20 ms, and those in transit
  // The firmware: one report per millisecond, numbered from 1. It runs until TearDown, beyond the life of the test's
  // locals: `report` may capture only its own data or the fixture's.
  void talk(const std::function<Bytes(std::uint32_t)>& report) {
    firmware_ = std::thread([this, report] {
      for (std::uint32_t number = 1; !is_off_;) {
        if (!is_silent_) bed_->stream(0, report(number++));
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
  }
  void TearDown() override {
    is_off_ = true;
    if (firmware_.joinable()) firmware_.join();
  }
  const SimulatedHid raw_{.vendor = 0xCAFE,
                          .product = 0x4004,
                          .maker = "Me",
                          .name = "My arm",
                          .serial = "R-1",
                          .interfaces = {{0xFF4B, 1}}};
  std::unique_ptr<HidTestbed> bed_;
  std::thread firmware_;
  std::atomic<bool> is_off_{false}, is_silent_{false};
};

}  // namespace kerf::test
