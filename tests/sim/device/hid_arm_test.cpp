// Arms on HID: kinematics and reports of their drivers, and the way of a force through the hidapi of the system to a
// simulated arm. None was tried on hardware.
#include "sim/device/hid_arm.h"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/device/raw_arm.h"
#include "sim/device/woody_arm.h"
#include "tests/sim/device/force_scene.h"
#include "tests/support/woody_firmware.h"

namespace kerf::hid_arm_test {
namespace {

using namespace test;

// ---- WoodenHaptics

TEST(WoodyArm, TheTorquesOfAForceAreThoseOfItsWorkAlongEachMotor) {
  const WoodyModel model;
  for (const std::array<int, 6> counts :
       {std::array{0, 0, 6000, 0, 0, 0}, std::array{500, 3000, 5000, 0, 0, 0}, std::array{-900, 5000, 8000, 0, 0, 0}}) {
    const WoodyPose pose = woodyPose(model, counts);
    for (std::size_t motor = 0; motor < 3; ++motor) {
      std::array<int, 6> more = counts, less = counts;
      more[motor] += 5;
      less[motor] -= 5;
      const double radians = 10 * 2 * std::numbers::pi / model.counts_per_turn[motor];
      const Vec3d slope = (woodyPose(model, more).position - woodyPose(model, less).position) / radians;
      EXPECT_LT((slope - pose.jacobian.col(static_cast<int>(motor))).norm(), 1e-3) << motor;
    }
    const Vec3d force(0.3, -0.7, 1.1);
    const Vec3d torque = woodyCurrents(model, pose.jacobian, force) * model.newton_mm_per_ampere / 1000;
    EXPECT_LT((torque - pose.jacobian.transpose() * force).norm(), 1e-9);
  }
}

// A link that stands upright and one that is level: 245 - 220 mm ahead, 80 + 205 - 80 mm up.
TEST(WoodyArm, AtHomeItStandsAsItIsBuiltWhicheverWayItsMotorsCount) {
  for (const WoodyModel& model : {WoodyModel{}, serialWoody()}) {
    std::array<int, 6> home{};
    std::copy(model.home.begin(), model.home.end(), home.begin());
    const WoodyPose pose = woodyPose(model, home);
    EXPECT_LT((pose.position - Vec3d(25, 0, 205)).norm(), 1e-9) << pose.position.transpose();

    // What turns body and links the way in which their angles grow moves the tip to the left, ahead, and up.
    std::array<int, 6> further = home;
    for (std::size_t n = 0; n < 3; ++n) further[n] += static_cast<int>(10 * model.direction[n]);
    const Vec3d way = woodyPose(model, further).position - pose.position;
    EXPECT_TRUE(way[0] > 0 && way[1] > 0 && way[2] > 0) << way.transpose();
  }
}

TEST(WoodyArm, NoCurrentIsLargerThanTheMotorsBear) {
  const WoodyPose pose = woodyPose({}, {0, 3000, 5000, 0, 0, 0});
  const Vec3d huge = woodyCurrents({}, pose.jacobian, {0, 0, 1e4}),
              little = woodyCurrents({}, pose.jacobian, {0, 0, 1});
  EXPECT_NEAR(huge.cwiseAbs().maxCoeff(), kWoodyMostCurrent, 1e-9);
  EXPECT_LT((huge.normalized() - little.normalized()).norm(), 1e-9) << "its direction is kept";
}

int wordAt(const Bytes& bytes, std::size_t at) { return static_cast<std::int16_t>(bytes[at] | (bytes[at + 1] << 8)); }

// ---- Kerf's own profile

TEST(RawArm, WhatIsSentIsReadAgain) {
  HandFrame hand;
  hand.number = 77;
  hand.time_ns = 1'234'567'000;
  hand.pose = {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {12.3456, -0.0001, 99}};
  hand.velocity = {1, -2, 3.5};
  hand.buttons = 0x80000003;
  hand.gives_torque = true;
  hand.most_force = 7.9;
  hand.most_torque = 100;
  hand.most_stiffness = 2.5;
  const RawArmReport report = encodeRawHand(hand);
  EXPECT_EQ((std::vector<std::uint8_t>(report.begin(), report.begin() + 16)),
            (std::vector<std::uint8_t>{'K', 'A', 1, 1, 77, 0, 0, 0, 0x87, 0xD6, 0x12, 0, 0x40, 0xE2, 0x01, 0x00}));
  HandFrame read;
  ASSERT_EQ(decodeRawHand(report, read), FrameFault::kNone);
  EXPECT_EQ(read.number, 77u);
  EXPECT_EQ(read.time_ns, hand.time_ns);
  EXPECT_LT((read.pose.translation - hand.pose.translation).norm(), 1e-4);
  EXPECT_LT(read.pose.rotation.angularDistance(hand.pose.rotation), 1e-3);
  EXPECT_EQ(read.buttons, hand.buttons);
  EXPECT_TRUE(read.is_ready && read.senses_orientation && read.gives_torque);
  EXPECT_DOUBLE_EQ(read.most_force, 7.9);
  EXPECT_DOUBLE_EQ(read.most_stiffness, 2.5);

  ForceFrame force;
  force.hand_number = 77;
  force.force = {1.5, -2.25, 0.0003};
  force.torque = {0.5, 0, -1};
  force.is_enabled = true;
  ForceFrame felt;
  ASSERT_EQ(decodeRawForce(encodeRawForce(force), felt), FrameFault::kNone);
  EXPECT_LT((felt.force - force.force).norm(), 1e-4);
  EXPECT_LT((felt.torque - force.torque).norm(), 1e-3);
  EXPECT_TRUE(felt.is_enabled);
  EXPECT_EQ(felt.deadline_ms, 20u);
  force.force[0] = std::numeric_limits<double>::quiet_NaN();
  ASSERT_EQ(decodeRawForce(encodeRawForce(force), felt), FrameFault::kNone);
  EXPECT_FALSE(felt.is_enabled) << "what is no number is no force";
  EXPECT_EQ(felt.force, Vec3d::Zero());
}

TEST(RawArm, WhatIsNoneIsRefusedAsAWhole) {
  const RawArmReport good = encodeRawHand({});
  HandFrame hand;
  hand.number = 5;
  const auto faultWith = [&](std::size_t at, std::uint8_t value) {
    RawArmReport bad = good;
    bad[at] = value;
    return decodeRawHand(bad, hand);
  };
  EXPECT_EQ(decodeRawHand(std::span(good).first(63), hand), FrameFault::kLength);
  EXPECT_EQ(faultWith(0, 'k'), FrameFault::kMagic);
  EXPECT_EQ(faultWith(2, 2), FrameFault::kVersion);
  EXPECT_EQ(faultWith(3, 2), FrameFault::kKind);
  EXPECT_EQ(faultWith(31, 0), FrameFault::kOutOfRange) << "no unit quaternion";
  EXPECT_EQ(faultWith(15, 0x7F), FrameFault::kOutOfRange) << "200 m away";
  EXPECT_EQ(hand.number, 5u);
}

// ---- On the wire

class HidArms : public OnTestbed {};

TEST_F(HidArms, AreFoundByPathAndSerialNeverByPlace) {
  bed_->plugIn({.vendor = 0x1234, .product = 6, .name = "Woody", .interfaces = {{0xFF00, 1}}});
  bed_->plugIn({.vendor = 0x16c0,
                .product = 0x486,
                .name = "Teensy",
                .serial = "T",
                .interfaces = {{0xFFAB, 0x200}},
                .port = 2,
                .first_node = 1});
  SimulatedHid own = raw_;
  own.port = 3;
  own.first_node = 2;
  bed_->plugIn(own);
  bed_->plugIn({.vendor = 0x16c0,
                .product = 0x486,
                .name = "Other Teensy",
                .interfaces = {{0xFFC9, 4}},
                .port = 4,
                .first_node = 3});
  const std::vector<FoundArm> arms = findArms();
  ASSERT_EQ(arms.size(), 3u);
  EXPECT_STREQ(chooseArm(arms, "T")->driver->id, "woody");
  EXPECT_STREQ(chooseArm(arms, "R-1")->driver->id, "rawhid");
  EXPECT_FALSE(chooseArm(arms, "")) << "three of them";
  const auto none = chooseArm(arms, "/dev/hidraw7");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("docs/reference/device-bridge.md"), std::string::npos);
}

TEST_F(HidArms, WoodyOfBothLengthsGivesItsPlaceAndGetsCurrents) {
  for (const bool is_teensy : {false, true}) {
    const std::size_t size = is_teensy ? 64 : 14;
    bed_.reset();
    bed_ = std::make_unique<HidTestbed>();
    if (is_teensy)
      bed_->plugIn({.vendor = 0x16c0, .product = 0x486, .name = "Teensy", .interfaces = {{0xFFAB, 0x200}}});
    else
      bed_->plugIn({.vendor = 0x1234, .product = 6, .name = "Woody", .interfaces = {{0xFF00, 1}}});
    WoodyFirmware firmware(*bed_, 0, {-200, 4100, 77}, size);
    is_off_ = false;
    talk([=] { return firmware.report(); });
    {
      auto arm = open();
      ASSERT_TRUE(arm);
      arm->enable(true);
      const Vec3d force(0, 0, 1);
      Pusher pusher(*arm, force);

      // Its encoders do not say where it is.
      ASSERT_TRUE(until([&] { return pusher.is_valid.load(); }));
      EXPECT_TRUE(arm->needsCalibration());
      const std::uint64_t before = arm->counts().forces;
      ASSERT_TRUE(until([&] { return arm->counts().forces > before + 50; }));
      for (const Bytes& report : bed_->written(0)) EXPECT_EQ(report, Bytes(size + 1)) << "no force uncalibrated";
      ASSERT_TRUE(calibrated(*arm));
      ASSERT_TRUE(until([&] {
        for (const Bytes& report : bed_->written(0))
          if (wordAt(report, 7) == 1) return wordAt(report, 13) == 6000;
        return false;
      }));

      firmware.turn({0, 3000, -1000});
      const std::array<int, 6> counts{0, 3000, 5000, 0, 0, 0};
      const Vec3d currents = woodyCurrents({}, woodyPose({}, counts).jacobian, force);
      ASSERT_TRUE(until([&] {
        const Bytes last = lastWritten();
        return last.size() >= 15 && std::abs(wordAt(last, 1) - currents[0]) <= 1 &&
               std::abs(wordAt(last, 3) - currents[1]) <= 1 && std::abs(wordAt(last, 5) - currents[2]) <= 1;
      })) << currents.transpose();
      EXPECT_EQ(lastWritten().size(), size + 1);
      HandFrame hand;
      ASSERT_TRUE(arm->lastHand(hand));
      EXPECT_LT((hand.pose.translation - woodyPose({}, counts).position).norm(), 1e-9);

      // Numbers that are none.
      EXPECT_LE(forcesAfter([&] { pusher.gives_nan = true; }, [&](const Bytes& b) { return b != Bytes(size + 1); }),
                kDeadMan);
    }
    EXPECT_EQ(lastWritten(), Bytes(size + 1)) << "no force at the end";
    is_off_ = true;
    firmware_.join();
  }
}

// Its encoders count on from where it was switched on: a force by them would point elsewhere.
TEST_F(HidArms, AWoodyThatDoesNotTakeItsCalibrationIsGivenNoForce) {
  bed_->plugIn({.vendor = 0x1234, .product = 6, .name = "Woody", .interfaces = {{0xFF00, 1}}});
  WoodyFirmware firmware(*bed_, 0, {0, 0, 5900});
  firmware.ignoreCalibration(true);
  talk([=] { return firmware.report(); });
  auto arm = open();
  ASSERT_TRUE(arm);
  arm->enable(true);
  Pusher pusher(*arm, {0, 0, 1});
  const auto trouble = [&] { return arm->counts().trouble; };
  ASSERT_TRUE(until([&] { return pusher.is_valid && trouble().empty(); }));
  EXPECT_TRUE(arm->calibrate());
  EXPECT_TRUE(until([&] { return trouble().find("did not take its calibration") != std::string::npos; })) << trouble();
  EXPECT_TRUE(arm->needsCalibration());
  for (const Bytes& report : bed_->written(0))
    for (const std::size_t motor : {1, 3, 5}) EXPECT_EQ(wordAt(report, motor), 0);

  firmware.ignoreCalibration(false);
  ASSERT_TRUE(calibrated(*arm));
  EXPECT_TRUE(until([&] { return wordAt(lastWritten(), 5) != 0; }));
  EXPECT_TRUE(until([&] { return trouble().empty(); })) << trouble();

  // Once more, and it does not take that: where it stands is not known any more.
  firmware.turn({0, 100, 0});
  firmware.ignoreCalibration(true);
  EXPECT_TRUE(arm->calibrate());
  EXPECT_TRUE(arm->needsCalibration());
  EXPECT_TRUE(until([&] {
    return trouble().find("did not take its calibration") != std::string::npos && lastWritten() == Bytes(15);
  })) << trouble();
  EXPECT_TRUE(arm->needsCalibration());
}

TEST_F(HidArms, OurOwnProfileClosesTheLoopAndGivesNoForceWithoutNews) {
  bed_->plugIn(raw_);
  std::atomic<std::uint32_t> number{0};
  talk([&] {
    HandFrame hand;
    hand.number = ++number;
    hand.pose.translation = {5, 0, 0};
    const RawArmReport report = encodeRawHand(hand);
    return Bytes(report.begin(), report.end());
  });
  auto arm = open("R-1");
  ASSERT_TRUE(arm);
  arm->enable(true);
  Pusher pusher(*arm, {0, 0, 10});
  const auto felt = [&] {
    ForceFrame force;
    const Bytes last = lastWritten();
    if (last.size() == 65) (void)decodeRawForce(std::span(last).subspan(1), force);
    return force;
  };
  ASSERT_TRUE(until([&] { return felt().is_enabled && felt().force[2] > 2.99; }));
  EXPECT_LE(felt().force[2], 3 + 1e-3) << "clamped";

  const auto gives = [](const Bytes& bytes) {
    ForceFrame force;
    return bytes.size() == 65 && decodeRawForce(std::span(bytes).subspan(1), force) == FrameFault::kNone &&
           force.is_enabled;
  };
  EXPECT_LE(forcesAfter([&] { pusher.hangs = true; }, gives), kDeadMan) << "a stall of the haptic thread";
  pusher.hangs = false;
  ASSERT_TRUE(until([&] { return felt().is_enabled; }));
  EXPECT_LE(forcesAfter([&] { is_silent_ = true; }, gives), kDeadMan) << "a silent arm";
  EXPECT_TRUE(until([&] { return !pusher.is_valid; }));
  is_silent_ = false;
  ASSERT_TRUE(until([&] { return felt().is_enabled; })) << "it fades in again";

  // Unplugged in the middle.
  is_silent_ = true;
  bed_->unplug(raw_);
  EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan);
  ASSERT_TRUE(until([&] { return arm->isGone(); }));
  EXPECT_NE(arm->counts().trouble.find("unplugged"), std::string::npos);
}

// The report under way is given its deadline by the arm; what follows is news, and fades in.
TEST_F(HidArms, AWriteThatIsStuckIsFollowedByNoOldForce) {
  bed_->plugIn(raw_);
  std::atomic<std::uint32_t> number{0};
  talk([&] {
    HandFrame hand;
    hand.number = ++number;
    const RawArmReport report = encodeRawHand(hand);
    return Bytes(report.begin(), report.end());
  });
  auto arm = open();
  ASSERT_TRUE(arm);
  arm->enable(true);
  Pusher pusher(*arm, {0, 0, 10});
  const auto feltOf = [](const Bytes& bytes) {
    ForceFrame force;
    EXPECT_EQ(decodeRawForce(std::span(bytes).subspan(1), force), FrameFault::kNone);
    return force;
  };
  ASSERT_TRUE(until([&] { return !lastWritten().empty() && feltOf(lastWritten()).force[2] > 2.9; }));

  bed_->holdWrites(0, true);
  ASSERT_TRUE(until([&] { return bed_->heldWrites(0) == 1; }));
  EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan) << "no hand comes, none is taken";
  EXPECT_EQ(bed_->heldWrites(0), 1u);
  bed_->forgetWritten(0);
  bed_->holdWrites(0, false);
  ASSERT_TRUE(until([&] { return bed_->written(0).size() > 3; }));
  const std::vector<Bytes> after = bed_->written(0);
  EXPECT_LE(feltOf(after[0]).deadline_ms, 20u);
  for (std::size_t n = 1; n < 4; ++n) EXPECT_LT(feltOf(after[n]).force[2], 1) << n;
  ASSERT_TRUE(until([&] { return feltOf(lastWritten()).force[2] > 2.9; })) << "it fades in again";
}

}  // namespace
}  // namespace kerf::hid_arm_test
