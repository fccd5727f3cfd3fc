// The full path of a force: haptic loop, mailbox, datagrams, the dead-man of a bridge, the arm's motors; and back. All
// on simulated arms. Frame stamps measure the duration of a force, independent of machine load.
#include "sim/device/arm/bridge_device.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <thread>

#include "bridges/simulated/arm_simulator.h"
#include "sim/device/hid/device_driver.h"
#include "sim/live/haptic_thread.h"
#include "tests/sim/block_scene.h"
#include "tests/sim/haptic_scene.h"

namespace kerf::bridge_device_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::int64_t kMs = 1'000'000;  // ns
constexpr std::int64_t kDeadManNs = 20 * kMs;
// Kerf's 20 ms, the arm's next tick, and the transit of a frame. The system may suspend Kerf's thread between clock and
// socket.
constexpr double kForcelessMs = 20 + 2;

template <class Condition>
bool until(const Condition& holds, int most_ms = 20000) {
  const auto end = steady_clock::now() + milliseconds(most_ms);
  while (steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
  return holds();
}
CutPath way(const std::vector<std::pair<double, Vec3d>>& points) {
  CutPath path;
  for (const auto& [t, p] : points) path.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}});
  path.cuts.assign(path.poses.size() - 1, 1);
  return path;
}
CutPath pressesFor(double seconds) { return way({{0, {0, 0, 1}}, {0.3, {0, 0, -4}}, {seconds, {0, 0, -4}}}); }

// Replaces the haptic thread: a wall at z = 0.
class WallLoop {
 public:
  WallLoop(BridgeDevice& device, double stiffness) : device_(device), stiffness_(stiffness) {
    thread_ = std::thread([this] { run(); });
  }
  ~WallLoop() {
    is_stopping_ = true;
    thread_.join();
  }
  std::atomic<bool> hangs{false}, gives_nan{false};
  std::atomic<bool> is_valid{false};
  /// deviceClock() after the last finite force was written; before the last hand was taken.
  std::atomic<std::int64_t> wrote_ns{0}, taken_ns{0};

 private:
  void run() {
    device_.arm();
    for (auto due = steady_clock::now(); !is_stopping_; due += milliseconds(1)) {
      std::this_thread::sleep_until(due);
      if (hangs) continue;
      const std::int64_t now = deviceClock();
      const DeviceSample sample = device_.read();
      if (sample.is_valid) taken_ns = now;
      is_valid = sample.is_valid != 0;
      DeviceForce force;
      const double z = sample.T_world_device.translation[2];
      if (sample.is_valid && z < 0) force.force[2] = -stiffness_ * z;
      const bool is_nan = gives_nan;
      if (is_nan) force.force[2] = std::numeric_limits<double>::quiet_NaN();
      device_.write(force);
      if (!is_nan) wrote_ns = deviceClock();
    }
    device_.write({});
    device_.disarm();
  }
  BridgeDevice& device_;
  const double stiffness_;
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

// Output of a transport on the test's own clock.
TEST(ArmLink, ForceAndDeadlineEndTwentyMillisecondsAfterTheOlderNews) {
  constexpr std::int64_t kNow = 1'000'000 * kMs;
  for (const std::int64_t hand_age : {0 * kMs, 7 * kMs, 25 * kMs})
    for (const std::int64_t wish_age : {0 * kMs, 3 * kMs, 12 * kMs, 25 * kMs}) {
      ArmLink link;
      link.may_give_force = true;
      link.wishes.back() = {.force = {0, 0, 1}, .is_enabled = true, .written_ns = kNow - wish_age};
      link.wishes.publish();
      const ArmLink::Hand hand{.frame = {}, .came_ns = kNow - hand_age};
      const std::int64_t oldest = kNow - std::max(hand_age, wish_age);
      for (std::int64_t now = kNow; now < kNow + 30 * kMs; now += kMs / 10) {
        const ForceFrame frame = link.answer(hand, now);
        EXPECT_EQ(frame.is_enabled, now - oldest <= kDeadManNs - kMs) << now - oldest;
        EXPECT_EQ(frame.force, frame.is_enabled ? Vec3d(0, 0, 1) : Vec3d(0, 0, 0));
        if (!frame.is_enabled) continue;
        const std::int64_t ends = now + frame.deadline_ms * kMs;
        EXPECT_LE(ends, oldest + kDeadManNs) << "whatever happens to the transport's thread";
        EXPECT_GT(ends, oldest + kDeadManNs - kMs) << "no sooner than whole milliseconds make it";
      }
    }
}

class Bridge : public testing::Test {
 protected:
  void open(BridgeOptions options = {}) {
    options.start.translation = {0, 0, 1};
    auto device = BridgeDevice::open(options);
    ASSERT_TRUE(device) << device.error().message();
    device_ = std::move(*device);
    device_->enable(true);
  }
  void press(double most_force = 8) {
    auto arm = ArmSimulator::start(pressesFor(100), {.port = device_->port(), .hand = {}, .most_force = most_force});
    ASSERT_TRUE(arm);
    arm_ = std::move(*arm);
  }
  /// Duration of the arm's force after `since`, by frame stamps, ms.
  double forceAfterMs(std::int64_t since) const {
    EXPECT_TRUE(until([&] { return !arm_->report().is_enabled; }));
    return 1e-6 * static_cast<double>(arm_->report().stopped_ns - since);
  }
  bool isPushed() const { return arm_->report().is_enabled && arm_->report().force[2] > 0.5; }
  std::unique_ptr<BridgeDevice> device_;
  std::unique_ptr<ArmSimulator> arm_;
};

TEST(BridgeAddress, OtherMachinesAreRefused) {
  EXPECT_EQ(parseBridgeAddress("udp:4417").value(), 4417);
  EXPECT_EQ(parseBridgeAddress("udp:localhost:1").value(), 1);
  EXPECT_EQ(parseBridgeAddress("udp:127.0.0.1:65535").value(), 65535);
  for (const char* bad :
       {"udp:192.168.0.7:4417", "udp:0.0.0.0:4417", "udp:", "udp:65536", "tcp:4417", "4417", "udp:-1", "udp:4417x"}) {
    const auto port = parseBridgeAddress(bad);
    EXPECT_FALSE(port) << bad;
  }
}

TEST_F(Bridge, ListensOnLoopbackAlone) {
  open();
  const std::string port = fmt::format(":{:04X}", device_->port());
  std::ifstream table("/proc/net/udp");
  int found = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.find(port + " ") == std::string::npos) continue;
    ++found;
    EXPECT_NE(line.find("0100007F" + port), std::string::npos) << line;
  }
  EXPECT_EQ(found, 1);
}

TEST_F(Bridge, AgainstAWallTheForceIsTheSpringsAndTheClampHolds) {
  open({.limits = {.force = 3, .rate = 500, .ramp_s = 0.2}});
  WallLoop wall(*device_, 1.0);
  press();
  ASSERT_TRUE(until([&] { return isPushed(); }));
  std::this_thread::sleep_for(milliseconds(700));
  const ArmReport report = arm_->report();
  // A hand of 0.3 N/mm aims 4 mm inside. The two springs settle at K z = 0.3 (4 - z), within the friction.
  EXPECT_NEAR(-report.position[2], 4 * 0.3 / 1.3, 0.25);
  EXPECT_LE(report.most_force, 3 + 1e-9);
}

TEST_F(Bridge, WhatTheDeviceSaysItCanIsAClampToo) {
  open({.limits = {.force = 3, .rate = 1e6, .ramp_s = 0.1}});
  WallLoop wall(*device_, 5.0);
  press(0.8);
  ASSERT_TRUE(until([&] { return arm_->report().force[2] > 0.7; }));
  std::this_thread::sleep_for(milliseconds(300));
  EXPECT_NEAR(arm_->report().most_force, 0.8, 1e-6);
}

TEST_F(Bridge, NotEnabledItGivesNoForce) {
  open();
  device_->enable(false);
  WallLoop wall(*device_, 1.0);
  press();
  ASSERT_TRUE(until([&] { return arm_->report().position[2] < -2; }));
  EXPECT_EQ(arm_->report().most_force, 0);
  device_->enable(true);
  ASSERT_TRUE(until([&] { return isPushed(); }));
  device_->enable(false);
  EXPECT_LE(forceAfterMs(deviceClock()), kForcelessMs);
}

TEST_F(Bridge, WithoutNewsNeitherSideGivesForce) {
  open();
  WallLoop wall(*device_, 1.0);
  press();
  ASSERT_TRUE(until([&] { return isPushed(); }));

  wall.hangs = true;
  ASSERT_TRUE(until([&] { return !arm_->report().is_enabled; }));
  EXPECT_LE(forceAfterMs(wall.wrote_ns), kForcelessMs) << "a stall of the haptic thread";
  wall.hangs = false;
  ASSERT_TRUE(until([&] { return isPushed(); })) << "it fades in again";

  arm_->hang(true);
  EXPECT_LE(forceAfterMs(deviceClock()), kForcelessMs) << "the bridge hangs: the arm's dead-man";
  ASSERT_TRUE(until([&] { return !wall.is_valid && !device_->counts().is_enabled; })) << "and Kerf knows";
  EXPECT_LE(wall.taken_ns - device_->counts().newest_came_ns, kDeadManNs) << "no hand is taken that is older";
  EXPECT_GE(arm_->report().forceless, 1u);
}

TEST_F(Bridge, NumbersThatAreNoneNeverReachTheMotors) {
  open();
  WallLoop wall(*device_, 1.0);
  press();
  ASSERT_TRUE(until([&] { return isPushed(); }));
  arm_->sendNan();
  ASSERT_TRUE(until([&] { return device_->counts().refused == 1; }));
  EXPECT_EQ(device_->counts().last_fault, nameOf(FrameFault::kNotFinite));

  wall.gives_nan = true;
  ASSERT_TRUE(until([&] { return !arm_->report().is_enabled; }));
  EXPECT_LE(forceAfterMs(wall.wrote_ns), kForcelessMs);
  wall.gives_nan = false;
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_FALSE(arm_->report().is_enabled) << "a fault stays until a person says so";
  device_->enable(false);
  std::this_thread::sleep_for(milliseconds(20));
  device_->enable(true);
  EXPECT_TRUE(until([&] { return isPushed(); }));
  EXPECT_TRUE(std::isfinite(arm_->report().most_force));
}

TEST_F(Bridge, AnExitSaysZeroAtOnce) {
  open();
  std::int64_t ended = 0;
  {
    WallLoop wall(*device_, 1.0);
    press();
    ASSERT_TRUE(until([&] { return isPushed(); }));
    ended = deviceClock();
  }
  device_.reset();
  EXPECT_LE(forceAfterMs(ended), kForcelessMs);
  EXPECT_EQ(arm_->report().force, Vec3d::Zero());
}

TEST_F(Bridge, KilledKerfLeavesNoForce) {
  int ports[2];
  ASSERT_EQ(::pipe(ports), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto device = BridgeDevice::open({});
    if (!device) ::_exit(1);
    (*device)->enable(true);
    const std::uint16_t port = (*device)->port();
    if (::write(ports[1], &port, sizeof port) != sizeof port) ::_exit(1);
    WallLoop wall(**device, 1.0);
    std::this_thread::sleep_for(std::chrono::seconds(60));
    ::_exit(0);
  }
  std::uint16_t port = 0;
  ASSERT_EQ(::read(ports[0], &port, sizeof port), static_cast<ssize_t>(sizeof port));
  arm_ = std::move(*ArmSimulator::start(pressesFor(100), {.port = port, .hand = {}}));
  const bool was_pushed = until([&] { return isPushed(); });
  ::kill(child, SIGKILL);
  EXPECT_TRUE(was_pushed);
  EXPECT_LE(forceAfterMs(deviceClock()), kForcelessMs);
  ::waitpid(child, nullptr, 0);
}

TEST_F(Bridge, AKilledBridgeIsKnownInTwentyMilliseconds) {
  open();
  const std::uint16_t port = device_->port();
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto arm = ArmSimulator::start(pressesFor(100), {.port = port, .hand = {}});
    std::this_thread::sleep_for(std::chrono::seconds(60));
    ::_exit(arm ? 0 : 1);
  }
  {
    WallLoop wall(*device_, 1.0);
    const bool was_enabled = until([&] { return device_->counts().is_enabled && wall.is_valid; });
    ::kill(child, SIGKILL);
    EXPECT_TRUE(was_enabled);
    EXPECT_TRUE(until([&] { return !wall.is_valid && !device_->counts().is_enabled; }));
    EXPECT_LE(wall.taken_ns - device_->counts().newest_came_ns, kDeadManNs) << "no hand is taken that is older";
  }
  ::waitpid(child, nullptr, 0);
}

TEST_F(Bridge, AHandThatLeapsTakesTheToolAlongFromWhereTheToolIs) {
  open();
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  there.sin_port = htons(device_->port());
  HandFrame frame;
  const auto sampleAfter = [&](const Vec3d& p, std::uint32_t buttons) {
    ++frame.number;
    frame.pose.translation = p;
    frame.buttons = buttons;
    const auto bytes = encode(frame);
    const std::uint64_t before = device_->counts().hands;
    ::sendto(socket, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&there), sizeof there);
    EXPECT_TRUE(until([&] { return device_->counts().hands > before; }));
    std::this_thread::sleep_for(milliseconds(3));
    return device_->read();
  };
  device_->arm();
  EXPECT_EQ(sampleAfter({50, 0, 0}, 0).T_world_device.translation, Vec3d(0, 0, 1)) << "the hand finds the tool";
  EXPECT_NEAR(sampleAfter({51, 0, 0}, 1).T_world_device.translation[0], 1, 1e-9);
  EXPECT_EQ(sampleAfter({51, 0, 0}, 1).pedal, 1) << "button 1";
  EXPECT_NEAR(sampleAfter({80, 0, 0}, 0).T_world_device.translation[0], 1, 1e-9) << "a leap";
  EXPECT_NEAR(sampleAfter({82, 0, 0}, 2).T_world_device.translation[0], 1, 1e-9) << "the clutch is held";
  EXPECT_NEAR(sampleAfter({84, 0, 0}, 0).T_world_device.translation[0], 1, 1e-9);
  EXPECT_NEAR(sampleAfter({85, 0, 0}, 0).T_world_device.translation[0], 2, 1e-9);
  ::close(socket);
}

TEST_F(Bridge, ATorqueGoesToADeviceThatGivesOneBoundByWhatItCan) {
  open({.limits = {.force = 3, .rate = 1e6, .ramp_s = 0.01}});
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  there.sin_port = htons(device_->port());
  ASSERT_EQ(::connect(socket, reinterpret_cast<const sockaddr*>(&there), sizeof there), 0);
  HandFrame hand;
  hand.most_torque = 40;
  ForceFrame felt;
  // Some ticks of a torque; then the device's last torque.
  const auto turnedBy = [&](const Vec3d& torque, bool gives) {
    hand.gives_torque = gives;
    for (int n = 0; n < 100; ++n) {
      ++hand.number;
      const auto bytes = encode(hand);
      ::send(socket, bytes.data(), bytes.size(), 0);
      std::this_thread::sleep_for(milliseconds(1));
      (void)device_->read();
      device_->write({Vec3d(0, 0, 1), torque});
    }
    std::this_thread::sleep_for(milliseconds(8));
    std::array<std::uint8_t, 256> got{};
    for (ssize_t size = 0; (size = ::recv(socket, got.data(), got.size(), MSG_DONTWAIT)) > 0;)
      EXPECT_EQ(decode(std::span(got).first(static_cast<std::size_t>(size)), felt), FrameFault::kNone);
  };
  device_->arm();
  turnedBy({0, 30, 0}, true);
  EXPECT_TRUE(felt.is_enabled);
  EXPECT_LT((felt.torque - Vec3d(0, 30, 0)).norm(), 1e-6);
  turnedBy({0, 300, 0}, true);
  EXPECT_NEAR(felt.torque.norm(), 40, 1e-6);
  turnedBy({0, 30, 0}, false);
  EXPECT_TRUE(felt.is_enabled);
  EXPECT_EQ(felt.torque, Vec3d::Zero()) << "it does not say that it gives one";
  turnedBy({0, std::numeric_limits<double>::quiet_NaN(), 0}, true);
  EXPECT_FALSE(felt.is_enabled) << "a torque that is none takes the force with it";
  ::close(socket);
}

// The real haptic thread with its allocation guard, on an arm of average friction with the coupling of its profile.
TEST_F(Bridge, TheWholeStackIsPassiveOnABlockAndCutsIt) {
  const DeviceProfile profile{.delay_s = 0.004, .mass_kg = 0.08, .friction = 0.05, .encoder_mm = 0.02};
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = test::oneTissue(200, 0.3, 100);
  model.settings.coupling = couplingFor(profile).settings;
  const Rigid3 start{Eigen::Quaterniond::Identity(), {0.1, 0.1, 1}};
  auto opened = BridgeDevice::open({.limits = {.force = 4, .rate = 2000, .ramp_s = 0.1}, .start = start});
  ASSERT_TRUE(opened);
  BridgeDevice& device = **opened;
  device.enable(true);
  device.arm();  // a guarded device arms itself
  test::GuardedDevice guarded(&device);
  HapticThread haptic(model, {test::block({6, 4, 2}, 0.1)}, start, test::ordinaryHaptics());
  ASSERT_TRUE(haptic.start(guarded, {}, nullptr));

  const CutPath path =
      way({{0, {0, 0, 1}}, {1.0, {0, 0, 1}}, {2, {0, 0, -2}}, {4, {0, 0, -2}}, {4.5, {0, 0, 1}}, {6, {0, 0, 1}}});
  DeviceHand::Options hand{.mass_kg = profile.mass_kg, .friction = profile.friction, .encoder_mm = profile.encoder_mm};
  hand.delay_ticks = 1;
  auto arm = ArmSimulator::start(path, {.port = device.port(), .hand = hand});
  ASSERT_TRUE(arm);
  // A machine that stalls a thread for 20 ms latches. The person continues.
  ASSERT_TRUE(test::becomes(haptic, [&](const HapticReport& report) {
    if (report.is_latched && device.counts().is_talking) haptic.send(ClearLatch{});
    return (*arm)->report().is_over;
  }));
  haptic.stop();
  const ArmReport report = (*arm)->report();
  EXPECT_GT(haptic.report().objects[0].removed_mm3, 0.05);
  EXPECT_GT(report.most_force, 0.1);
  EXPECT_LE(report.most_force, 4 + 1e-9);
  EXPECT_LT(report.port_energy, 0.02) << "N mm given to the hand over the whole way";
  std::printf(
      "energy at most %.4f N mm, at the end %.4f; force at most %.2f N; age of a force at most %.1f ms; %llu stops\n",
      report.most_energy, report.port_energy, report.most_force, report.worst_age_ms,
      static_cast<unsigned long long>(report.forceless));
}

}  // namespace
}  // namespace kerf::bridge_device_test
