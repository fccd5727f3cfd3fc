// What the panel says of a gamepad, on simulated ones. Skipped where umockdev is not preloaded.
#include "ui/app/gamepad_link.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/hid_testbed.h"
#include "ui/app/space_mouse_link.h"

namespace kerf::gamepad_link_test {
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

class PadOfThePanel : public testing::Test {
 protected:
  void SetUp() override {
    if (!HidTestbed::isThere()) GTEST_SKIP() << "umockdev is not preloaded: run umockdev-wrapper kerf_led_tests";
    bed_ = std::make_unique<HidTestbed>();
  }
  std::unique_ptr<HidTestbed> bed_;
};

TEST_F(PadOfThePanel, SaysThatItShakesAndItsBattery) {
  bed_->plugIn({.vendor = 0x054c, .product = 0x0ce6, .name = "Pad", .interfaces = {{1, 5}}});
  GamepadLink link;
  EXPECT_TRUE(link.update({}).shake.empty()) << "nobody wants to know";
  const PadId id{0x054c, 0x0ce6};
  ASSERT_TRUE(until([&] { return link.update(id).can_shake; }));
  EXPECT_EQ(link.update(id).shake, "DualSense: shakes while it drills");
  EXPECT_FALSE(link.update(id).battery) << "it has said nothing yet";

  Bytes report(64);
  report[0] = 1;
  report[8] = 8;
  report[53] = 0x13;
  bed_->send(0, report);
  ASSERT_TRUE(until([&] { return link.update(id).battery.has_value(); }));
  EXPECT_EQ(textOf(*link.update(id).battery), "35 %, charging");
  EXPECT_TRUE(bed_->written(0).empty()) << "it is looked at, not told anything";
}

TEST_F(PadOfThePanel, SaysWhyItDoesNotShake) {
  bed_->plugIn({.vendor = 0x046d, .product = 0xc21d, .name = "Pad", .interfaces = {{1, 5}}});
  GamepadLink link;
  const PadId unknown{0x046d, 0xc21d}, elsewhere{0x045e, 0x02ea};
  ASSERT_TRUE(until([&] { return link.update(unknown).shake.find("not known to shake") != std::string::npos; }))
      << link.update(unknown).shake;
  EXPECT_FALSE(link.update(unknown).can_shake);
  EXPECT_NE(link.update(elsewhere).shake.find("no HID device"), std::string::npos) << "an Xbox pad on a cable";
}

TEST_F(PadOfThePanel, ASpaceMouseSaysItsBattery) {
  bed_->plugIn({.vendor = 0x256f, .product = 0xc62e, .name = "SpaceMouse Wireless"});
  SpaceMouseLink link;
  ASSERT_TRUE(until([&] { return link.read().has_value(); }));
  EXPECT_FALSE(link.battery());
  bed_->send(0, {0x17, 42, 0});
  ASSERT_TRUE(until([&] {
    (void)link.read();
    return link.battery().has_value();
  }));
  EXPECT_EQ(textOf(*link.battery()), "42 %");
}

}  // namespace
}  // namespace kerf::gamepad_link_test
