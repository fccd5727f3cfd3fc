// HID arms: reports of Kerf's profile, and the path of a force through the system's hidapi to a simulated arm.
#include "sim/device/arm/hid_arm.h"

#include <gtest/gtest.h>

#include "sim/device/arm/raw_arm.h"
#include "tests/sim/device/force_scene.h"

namespace kerf::hid_arm_test {
namespace {

using namespace test;

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
  bed_->plugIn(raw_);
  SimulatedHid second = raw_;
  second.serial = "R-2";
  second.port = 2;
  second.first_node = 1;
  bed_->plugIn(second);
  bed_->plugIn({.port = 3, .first_node = 2});
  const std::vector<FoundDevice> found = findDevices();
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(chooseDevice(found, "R-2")->path(), "/dev/hidraw1");
  EXPECT_TRUE(chooseDevice(found, "R-1")->isArm());
  EXPECT_FALSE(openArm("/dev/hidraw2", {})) << "a SpaceMouse is no arm";
  const auto none = openArm("/dev/hidraw7", {});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("docs/reference/device-bridge.md"), std::string::npos);
}

TEST_F(HidArms, OurOwnProfileClosesTheLoopAndGivesNoForceWithoutNews) {
  bed_->plugIn(raw_);
  talk([](std::uint32_t number) {
    HandFrame hand;
    hand.number = number;
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

  // Unplugged during a force.
  is_silent_ = true;
  bed_->unplug(raw_);
  EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan);
  ASSERT_TRUE(until([&] { return arm->isGone(); }));
  EXPECT_NE(arm->counts().trouble.find("unplugged"), std::string::npos);
}

// The arm itself ends the current report by its deadline. Reports after it are new and fade in.
TEST_F(HidArms, AWriteThatIsStuckIsFollowedByNoOldForce) {
  bed_->plugIn(raw_);
  talk([](std::uint32_t number) {
    HandFrame hand;
    hand.number = number;
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
  // The force fades in over time, and time may pass between two reports.
  for (std::size_t n = 1; n < 4; ++n) EXPECT_LT(feltOf(after[n]).force[2], 2.5) << n;
  ASSERT_TRUE(until([&] { return feltOf(lastWritten()).force[2] > 2.9; })) << "it fades in again";
}

}  // namespace
}  // namespace kerf::hid_arm_test
