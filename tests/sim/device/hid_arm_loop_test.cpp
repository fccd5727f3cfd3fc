// The closed loop of an HID arm: Kerf's output through the system's hidapi moves its mass, damper and encoders, and
// Kerf reads the result. A wall replaces the haptic thread.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>

#include "sim/device/arm/hid_arm.h"
#include "tests/sim/device/force_scene.h"
#include "tests/sim/device/simulated_arm.h"
#include "tests/support/temporary_folder.h"

namespace kerf::hid_arm_loop_test {
namespace {

using namespace test;
using std::chrono::milliseconds;

// Steps of an arm from Kerf's last frame to zero force: 20 ms, the current step, and a frame in transit.
constexpr int kForceless = 20 + 2;

CutPath way(const std::vector<std::pair<double, Vec3d>>& points) {
  CutPath path;
  for (const auto& [t, p] : points) path.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}});
  path.cuts.assign(path.poses.size() - 1, 1);
  return path;
}
CutPath pressesFor(double seconds) { return way({{0, {0, 0, 0}}, {0.3, {0, 0, -5}}, {seconds, {0, 0, -5}}}); }

// A wall half a millimetre below the tool's start, with the damping of a coupling.
class Wall {
 public:
  explicit Wall(const CouplingSettings& coupling) : stiffness_(coupling.stiffness), damping_(coupling.damping) {}
  Vec3d force(const DeviceSample& sample) {
    if (!sample.is_valid) {
      has_last_ = false;
      return Vec3d::Zero();
    }
    const double z = sample.T_world_device.translation[2];
    // Like the coupling's: an encoder velocity through a low-pass of 150 Hz.
    const double gain = 1 - std::exp(-2 * std::numbers::pi * 150 * kTick);
    speed_ = has_last_ ? speed_ + gain * ((z - last_) / kTick - speed_) : 0;
    last_ = z;
    has_last_ = true;
    const double depth = -kTop - z;
    if (depth <= 0) return Vec3d::Zero();
    return {0, 0, std::max(0.0, stiffness_ * depth - damping_ * speed_)};
  }

 private:
  static constexpr double kTop = 0.5;
  double stiffness_, damping_;
  double last_ = 0, speed_ = 0;
  bool has_last_ = false;
};

DeviceHand::Options bodyOf(const DeviceProfile& profile) {
  DeviceHand::Options out;
  out.mass_kg = profile.mass_kg;
  out.friction = profile.friction;
  out.encoder_mm = profile.encoder_mm;
  out.delay_ticks = static_cast<int>(std::lround(1000 * profile.delay_s)) - 1;  // one is in the loop
  return out;
}

class HidLoop : public OnTestbed {
 protected:
  void SetUp() override {
    OnTestbed::SetUp();
    if (!IsSkipped()) bed_->plugIn(raw_);
  }
  std::unique_ptr<ForceArm> opened() {
    auto arm = open();
    if (!arm) return nullptr;
    arm->enable(true);
    arm->arm();
    return arm;
  }
  // One tick of both, in lock-step: the arm reports its place, Kerf reads and answers, the answer is written.
  bool tick(SimulatedArm& body, ForceArm& arm, Wall& wall) {
    const std::uint64_t taken = arm.counts().hands;
    const bool goes_on = body.step();
    EXPECT_TRUE(until([&] { return arm.counts().hands > taken; }));
    const DeviceSample sample = arm.read();
    is_valid_ = sample.is_valid != 0;
    const std::uint64_t sent = arm.counts().forces;
    arm.write({wall.force(sample), Vec3d::Zero()});
    EXPECT_TRUE(until([&] { return arm.counts().forces > sent; }));
    return goes_on;
  }
  // Until it leans on the wall.
  void press(SimulatedArm& body, ForceArm& arm, Wall& wall) {
    for (int n = 0; n < 3000 && !(n > 600 && body.force()[2] > 0.5); ++n) tick(body, arm, wall);
    ASSERT_GT(body.force()[2], 0.5);
  }
  // Only the arm, until it gives no force.   @return  number of its steps with force.
  int stepsWithForce(SimulatedArm& body) {
    int steps = 0;
    for (; steps < 1000; ++steps) {
      std::this_thread::sleep_for(milliseconds(1));
      body.step();
      if (body.force().isZero(0)) break;
    }
    return steps;
  }
  const DeviceProfile profile_{.friction = 0.05, .encoder_mm = 0.02};
  const double rated_ = HandFrame{}.most_stiffness;  // N/mm
  const CouplingSettings coupling_ = couplingFor(profile_, {.stiffness = rated_}).settings;
  bool is_valid_ = false;
};

// Repeated presses. A fade-in while leaning on the wall gives energy by itself: the wall yields, then pushes. So a
// press interrupted by a busy machine, with more than 20 ms between two ticks, does not count.
TEST_F(HidLoop, NoEnergyGrowsAgainstAWallAtTheRatedStiffnessAndTheClampHolds) {
  EXPECT_EQ(coupling_.stiffness, rated_) << "such an arm bears what it is rated for";
  std::vector<std::pair<double, Vec3d>> presses;
  constexpr int kPresses = 16;
  for (int n = 0; n < kPresses; ++n) {
    presses.push_back({0.2 * n, {0, 0, 0}});
    presses.push_back({0.2 * n + 0.08, {0, 0, 0}});
    presses.push_back({0.2 * n + 0.14, {0, 0, -9}});
  }
  presses.push_back({0.2 * kPresses, {0, 0, 0}});
  DeviceHand::Options firm = bodyOf(profile_);
  firm.hand_stiffness = 1;
  SimulatedArm body(*bed_, way(presses), firm);
  auto opened = openArm(HidTestbed::path(0), {.limits = {.force = 3, .rate = 5000, .ramp_s = 0.02}});
  ASSERT_TRUE(opened) << opened.error().message();
  ForceArm& arm = *opened->arm;
  arm.enable(true);
  arm.arm();

  Wall wall(coupling_);
  int judged = 0;
  bool is_broken = true, was_in_air = true;
  double begun_with = 0, most = 0, most_left = 0;
  while (tick(body, arm, wall)) {
    (void)arm.update();
    EXPECT_LE(body.force().norm(), 3 * 1.01) << "N";
    const bool is_in_air = body.position()[2] > -0.3 && body.force().isZero(0);
    if (is_in_air && !was_in_air && !is_broken) {
      ++judged;
      most_left = std::max(most_left, body.energy() - begun_with);
    }
    if (is_in_air) {
      begun_with = body.energy();
      is_broken = false;
    } else {
      is_broken = is_broken || arm.felt().ramp < 1;
    }
    if (!is_broken) most = std::max(most, body.energy() - begun_with);
    was_in_air = is_in_air;
  }
  std::printf("%d presses: energy at most %.4f N mm, left %.4f; force at most %.2f N\n", judged, most, most_left,
              body.mostForce());
  // A hand of 1 N/mm that aims 9 mm down would balance at 4 N.
  EXPECT_GT(body.mostForce(), 2.5);
  if (judged == 0) GTEST_SKIP() << "this machine is too busy: no press went without a break";
  EXPECT_LT(most, 0.02) << "N mm given to the hand";
  EXPECT_LT(most_left, 0.02);
}

TEST_F(HidLoop, AStallOfTheHapticThreadTakesTheForceAway) {
  SimulatedArm body(*bed_, pressesFor(100), bodyOf(profile_));
  auto arm = opened();
  ASSERT_TRUE(arm);
  Wall wall(coupling_);
  press(body, *arm, wall);
  EXPECT_LE(stepsWithForce(body), kForceless);
  // The hand has moved on by millimetres, so the force of the wall rises slowly.
  for (int n = 0; n < 10; ++n) {
    tick(body, *arm, wall);
    EXPECT_LT(body.force().norm(), 3 * 0.2) << "it fades in again, over 100 ms";
  }
  for (int n = 0; n < 200; ++n) tick(body, *arm, wall);
  EXPECT_GT(body.force()[2], 0.2);
}

TEST_F(HidLoop, AForceThatIsNoNumberTakesTheForceAwayForGood) {
  SimulatedArm body(*bed_, pressesFor(100), bodyOf(profile_));
  auto arm = opened();
  ASSERT_TRUE(arm);
  Wall wall(coupling_);
  press(body, *arm, wall);
  (void)arm->read();
  arm->write({Vec3d::Constant(std::numeric_limits<double>::quiet_NaN()), Vec3d::Zero()});
  EXPECT_LE(stepsWithForce(body), kForceless);
  for (int n = 0; n < 100; ++n) {
    tick(body, *arm, wall);
    EXPECT_EQ(body.force(), Vec3d::Zero());
  }
}

TEST_F(HidLoop, AnUnpluggedArmIsKnownAndALeftOneGivesNoForce) {
  SimulatedArm body(*bed_, pressesFor(100), bodyOf(profile_));
  auto arm = opened();
  ASSERT_TRUE(arm);
  Wall wall(coupling_);
  press(body, *arm, wall);
  bed_->unplug(raw_);
  ASSERT_TRUE(until([&] { return arm->isGone(); }));
  std::this_thread::sleep_for(milliseconds(25));
  EXPECT_FALSE(arm->read().is_valid);
  EXPECT_LE(stepsWithForce(body), kForceless) << "its own deadline";
}

TEST_F(HidLoop, AKilledKerfLeavesNoForceBehind) {
  const TemporaryFolder folder;
  SimulatedArm body(*bed_, pressesFor(1000), bodyOf(profile_));
  const std::filesystem::path begun = folder.path() / "begun";
  Doomed kerf([&]() -> std::function<void()> {
    auto opened = openArm(HidTestbed::path(0), {.limits = {.force = 3, .rate = 500, .ramp_s = 0.1}});
    if (!opened) return {};
    opened->arm->enable(true);
    opened->arm->arm();
    std::ofstream(begun) << "";
    const std::shared_ptr<ForceArm> arm = std::move(opened->arm);
    return [arm, wall = std::make_shared<Wall>(coupling_)] { arm->write({wall->force(arm->read()), Vec3d::Zero()}); };
  });
  ASSERT_GT(kerf.process(), 0);
  ASSERT_TRUE(until([&] {
    body.answer();
    return std::filesystem::exists(begun);
  })) << "it begins to press once it is taken";
  // Both in real time now.
  for (int steps = 0; steps < 20000 && !(body.force()[2] > 0.5 && body.ticksWithForce() > 50); ++steps) {
    std::this_thread::sleep_for(milliseconds(1));
    body.step();
  }
  ASSERT_GT(body.force()[2], 0.5);
  kerf.kill();
  EXPECT_LE(stepsWithForce(body), kForceless);
}

}  // namespace
}  // namespace kerf::hid_arm_loop_test
