// A joystick of the window on a simulated device of the class PID. Skipped where umockdev is not preloaded.
#include "ui/app/joystick_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "tests/sim/device/pid_scene.h"

namespace kerf::joystick_link_test {
namespace {

template <class Condition>
bool until(const Condition& holds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return holds();
}

TEST(JoystickMap, IsAGamepadWhoseFirstButtonDrills) {
  DeviceReading reading;
  reading.axes = {0.5, -0.25, 0, 0, 0, 0.75};
  reading.buttons = 0b1011 | std::uint64_t{1} << 62;
  const GamepadState state = gamepadStateOf(reading);
  EXPECT_EQ(state.left_stick, Eigen::Vector2d(0.5, -0.25)) << "right, and away, as a gamepad's: down is +";
  EXPECT_EQ(state.right_stick, Eigen::Vector2d(0.75, 1)) << "twist, and the hat downwards";
  EXPECT_EQ(state.right_trigger, 1);
  EXPECT_EQ(state.left_trigger, 0);
  EXPECT_TRUE(state.a && state.right_bumper);
  EXPECT_FALSE(state.left_bumper);
}

TEST(JoystickMap, IsDampedAndShakenButNeverPushed) {
  const PidWish wish = pidWishOf({.strong = 1, .weak = 1});
  EXPECT_GT(wish.damping, 0);
  EXPECT_GT(wish.shake, 0);
  EXPECT_LE(wish.damping, 0.5);
  EXPECT_LE(wish.shake, 0.5);
  EXPECT_EQ(wish.right, 0);
  EXPECT_EQ(wish.away, 0);
  const PidWish rest = pidWishOf({});
  EXPECT_EQ(rest.damping, 0);
  EXPECT_EQ(rest.shake, 0);
}

class Joysticks : public test::PidDevices {
 protected:
  bool has(std::uint8_t report) const {
    const auto all = bed_->written(0);
    return std::any_of(all.begin(), all.end(), [&](const Bytes& one) { return one[0] == report; });
  }
};

TEST_F(Joysticks, LeadsByItsDescriptorAndIsGivenNoForceUnasked) {
  plugIn(3);
  JoystickLink link;
  ASSERT_TRUE(until([&] { return link.read().has_value(); }));
  EXPECT_EQ(link.news(), "FFBoard is ready");
  EXPECT_EQ(link.read()->left_stick[0], 0) << "it has said nothing yet";
  bed_->send(0, {1, 0xFF, 0xFF});
  ASSERT_TRUE(until([&] { return link.read()->left_stick[0] == 1; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_EQ(link.read()->left_stick[0], 1) << "it says nothing while nothing moves";

  for (int n = 0; n < 30; ++n) {
    link.shake({1, 1});
    std::this_thread::sleep_for(std::chrono::milliseconds(4));
  }
  EXPECT_TRUE(bed_->written(0).empty());
  EXPECT_NE(link.force().find("--joystick-force"), std::string::npos);
}

TEST_F(Joysticks, AskedForItIsShakenWhileItDrillsAndAtRestAfterwards) {
  plugIn(3);
  JoystickLink link(true);
  ASSERT_TRUE(until([&] { return link.read().has_value(); }));
  link.shake({});
  EXPECT_TRUE(bed_->written(0).empty()) << "it is opened for its effects when there is something to be felt";
  ASSERT_TRUE(until([&] {
    link.shake({1, 1});
    const auto all = bed_->written(0);
    return std::any_of(all.begin(), all.end(), [](const Bytes& one) { return one[0] == 4 && one[2] != 0; });
  })) << "a sine that is felt";
  for (const Bytes& one : bed_->written(0)) {
    const bool pushes = one[0] == 5 && (one[2] != 0 || one[3] != 0);
    EXPECT_FALSE(pushes) << "it is never pushed";
  }
  ASSERT_TRUE(until([&] {
    link.shake({});
    const auto all = bed_->written(0);
    const auto last = std::find_if(all.rbegin(), all.rend(), [](const Bytes& one) { return one[0] == 4; });
    return last != all.rend() && (*last)[2] == 0 && (*last)[3] == 0;
  }));
  bed_->unplug({.vendor = 0x1209, .product = 0xffb0, .name = "FFBoard", .interfaces = {{1, 4}}});
  ASSERT_TRUE(until([&] { return !link.read(); })) << "nobody's hand is on it any more";
  EXPECT_EQ(link.news(), std::nullopt) << "it was not told of";
}

TEST_F(Joysticks, AFullPoolIsSaidAndItLeadsAllTheSame) {
  plugIn(0);
  JoystickLink link(true);
  ASSERT_TRUE(until([&] { return link.read().has_value(); }));
  ASSERT_TRUE(until([&] {
    link.shake({1, 1});
    return link.force().find("full pool") != std::string::npos;
  })) << link.force();
  EXPECT_TRUE(link.read());
}

}  // namespace
}  // namespace kerf::joystick_link_test
