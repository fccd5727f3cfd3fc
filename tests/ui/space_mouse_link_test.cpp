// The window's SpaceMouse on a simulated device. Skipped where umockdev is not preloaded.
#include "ui/app/hand/space_mouse_link.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/hid_testbed.h"

namespace kerf::space_mouse_link_test {
namespace {

template <class Condition>
bool until(const Condition& holds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return holds();
}

TEST(SpaceMouseLink, IsFoundWhileTheProgramRunsTellsOnceAndIsFoundAgain) {
  if (!HidTestbed::isThere()) GTEST_SKIP() << "umockdev is not preloaded: run umockdev-wrapper kerf_led_tests";
  HidTestbed bed;
  SpaceMouseLink link;
  EXPECT_FALSE(link.read());
  EXPECT_FALSE(link.news());

  bed.plugIn({});
  ASSERT_TRUE(until([&] { return link.read().has_value(); }));
  EXPECT_EQ(link.news(), "SpaceNavigator is ready");
  EXPECT_FALSE(link.news()) << "once";
  bed.send(0, {1, 0x5E, 0x01, 0, 0, 0, 0});
  bed.send(0, {3, 2, 0});
  ASSERT_TRUE(until([&] { return link.read()->axes[0] == 1; }));
  EXPECT_TRUE(until([&] { return link.read()->buttons == 2; }));

  bed.unplug({});
  ASSERT_TRUE(until([&] { return !link.read(); })) << "nobody's hand is on it any more";
  EXPECT_EQ(link.news(), "SpaceNavigator was unplugged");

  bed.plugIn({.vendor = 0x256f, .product = 0xc635, .name = "SpaceMouse Compact", .port = 2, .first_node = 4});
  ASSERT_TRUE(until([&] { return link.read().has_value(); }));
  EXPECT_EQ(link.news(), "SpaceMouse Compact is ready");
}

}  // namespace
}  // namespace kerf::space_mouse_link_test
