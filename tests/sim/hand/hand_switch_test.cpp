#include "sim/hand/hand_switch.h"

#include <gtest/gtest.h>

namespace kerf::hand_switch_test {
namespace {

struct Hand final : DeviceSource {
  void arm() noexcept override { is_armed = true; }
  DeviceSample read() noexcept override { return sample; }
  void write(const DeviceForce& force) noexcept override { felt = force.force; }
  void placed(const Rigid3& T_world_tool) noexcept override { sample.T_world_device = T_world_tool; }
  void disarm() noexcept override { is_armed = false; }
  DeviceSample sample;
  Vec3d felt = Vec3d::Zero();
  bool is_armed = false;
};

DeviceForce pushed(double z) { return {Vec3d(0, 0, z), Vec3d::Zero()}; }

TEST(HandSwitch, WhoLeadsIsChangedBetweenTwoTicksAndFindsTheToolWhereItIs) {
  Hand mouse, arm;
  mouse.sample.T_world_device.translation = {1, 2, 3};
  HandSwitch hands(mouse);
  hands.arm();
  hands.read();
  hands.write(pushed(2));
  EXPECT_EQ(mouse.felt[2], 2);
  EXPECT_FALSE(arm.is_armed);

  hands.lead(&arm);
  EXPECT_TRUE(mouse.is_armed) << "not before the haptic thread reads";
  EXPECT_EQ(hands.read().T_world_device.translation, Vec3d(1, 2, 3));
  EXPECT_TRUE(arm.is_armed);
  EXPECT_FALSE(mouse.is_armed);
  EXPECT_EQ(mouse.felt, Vec3d::Zero());
  hands.write(pushed(1));
  EXPECT_EQ(arm.felt[2], 1);
}

TEST(HandSwitch, OneThatLeadsNoMoreIsInUseUntilTheHapticThreadReads) {
  Hand mouse, arm;
  HandSwitch hands(mouse);
  hands.arm();
  hands.lead(&arm);
  EXPECT_TRUE(hands.isInUse(&arm)) << "it may begin at any time";
  hands.read();
  hands.write(pushed(1));
  arm.sample.T_world_device.translation = {0, 0, 7};
  hands.read();

  hands.lead(nullptr);
  EXPECT_TRUE(hands.isInUse(&arm));
  EXPECT_EQ(hands.read().T_world_device.translation, Vec3d(0, 0, 7)) << "the mouse finds it there";
  EXPECT_FALSE(hands.isInUse(&arm));
  EXPECT_EQ(arm.felt, Vec3d::Zero());
  EXPECT_FALSE(arm.is_armed);
  hands.disarm();
  EXPECT_FALSE(mouse.is_armed);
}

}  // namespace
}  // namespace kerf::hand_switch_test
