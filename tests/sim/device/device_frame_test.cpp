#include "sim/device/frame/device_frame.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

namespace kerf::device_frame_test {
namespace {

HandFrame someHand() {
  HandFrame f;
  f.number = 7;
  f.time_ns = 123456789;
  f.pose = {Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vec3d::UnitX())), {10, -20, 30.5}};
  f.velocity = {1, 2, 3};
  f.angular = {0.1, 0.2, 0.3};
  f.buttons = 5;
  f.is_ready = true;
  f.senses_orientation = true;
  f.most_force = 3.5;
  f.most_stiffness = 0.75;
  return f;
}

TEST(DeviceFrame, WhatIsWrittenIsRead) {
  HandFrame got;
  ASSERT_EQ(decode(encode(someHand()), got), FrameFault::kNone);
  EXPECT_EQ(got.number, 7u);
  EXPECT_EQ(got.time_ns, 123456789u);
  EXPECT_NEAR((got.pose.translation - Vec3d(10, -20, 30.5)).norm(), 0, 1e-12);
  EXPECT_NEAR(got.pose.rotation.angularDistance(someHand().pose.rotation), 0, 1e-7);
  EXPECT_NEAR((got.velocity - Vec3d(1, 2, 3)).norm(), 0, 1e-12);
  EXPECT_EQ(got.buttons, 5u);
  EXPECT_TRUE(got.is_ready && got.senses_orientation && !got.gives_torque);
  EXPECT_FLOAT_EQ(static_cast<float>(got.most_force), 3.5F);
  EXPECT_NEAR(got.most_stiffness, 0.75, 1e-6);

  ForceFrame force;
  force.number = 9;
  force.hand_number = 7;
  force.force = {0, 0, 1.5};
  force.torque = {0, 100, 0};
  force.is_enabled = true;
  ForceFrame back;
  ASSERT_EQ(decode(encode(force), back), FrameFault::kNone);
  EXPECT_EQ(back.force, force.force);
  EXPECT_NEAR(back.torque[1], 100, 1e-12);
  EXPECT_TRUE(back.is_enabled);
  EXPECT_EQ(back.deadline_ms, 20u);
}

// The table of docs/reference/device-bridge.md, byte by byte: the reference for external bridges.
TEST(DeviceFrame, TheLayoutIsTheOneOfTheReference) {
  const auto bytes = encode(someHand());
  EXPECT_EQ(bytes[0], 'K');
  EXPECT_EQ(bytes[3], '1');
  EXPECT_EQ(bytes[4], 1) << "version";
  EXPECT_EQ(bytes[6], 1) << "kind";
  EXPECT_EQ(bytes[8], 7) << "number";
  const auto number = [&](std::size_t at) {
    std::uint64_t bits = 0;
    for (std::size_t n = 0; n < 8; ++n) bits |= std::uint64_t{bytes[at + n]} << (8 * n);
    return std::bit_cast<double>(bits);
  };
  EXPECT_DOUBLE_EQ(number(24), 0.010) << "x in m";
  EXPECT_DOUBLE_EQ(number(72), std::cos(0.25)) << "w stands last";
  EXPECT_DOUBLE_EQ(number(80), 0.001) << "m/s";
  EXPECT_EQ(bytes[128], 5) << "buttons";
  EXPECT_EQ(bytes[132], 3) << "flags";
}

TEST(DeviceFrame, WhatIsMalformedIsRefusedAndNothingOfItIsUsed) {
  const auto good = encode(someHand());
  const auto faultOf = [&](std::size_t at, std::uint8_t value) {
    auto bytes = good;
    bytes[at] = value;
    HandFrame out;
    out.number = 42;
    const FrameFault fault = decode(bytes, out);
    EXPECT_TRUE(fault == FrameFault::kNone || out.number == 42);
    return fault;
  };
  HandFrame out;
  EXPECT_EQ(decode(std::span(good).first(151), out), FrameFault::kLength);
  EXPECT_EQ(decode(std::span<const std::uint8_t>(), out), FrameFault::kLength);
  EXPECT_EQ(faultOf(0, 'X'), FrameFault::kMagic);
  EXPECT_EQ(faultOf(4, 2), FrameFault::kVersion);
  EXPECT_EQ(faultOf(6, 2), FrameFault::kKind);
  EXPECT_EQ(faultOf(79, 0x10), FrameFault::kOutOfRange) << "no unit quaternion";

  HandFrame bad = someHand();
  bad.pose.translation[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(decode(encode(bad), out), FrameFault::kNotFinite);
  bad = someHand();
  bad.pose.translation[0] = 20000;
  EXPECT_EQ(decode(encode(bad), out), FrameFault::kOutOfRange);
  bad = someHand();
  bad.most_force = -1;
  EXPECT_EQ(decode(encode(bad), out), FrameFault::kOutOfRange);
  ForceFrame force;
  force.force[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(decode(encode(force), force), FrameFault::kNotFinite);
}

}  // namespace
}  // namespace kerf::device_frame_test
