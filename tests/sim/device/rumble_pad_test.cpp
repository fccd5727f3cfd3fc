// The motors of gamepads: bytes, checksums by zlib's crc32, and what is written in which moment.
#include "sim/device/rumble_pad.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/device/force_scene.h"

namespace kerf {
namespace {

using namespace test;

using std::chrono::milliseconds;
using std::chrono::steady_clock;

TEST(Rumble, EachPadGetsItsBytes) {
  const Rumble rumble{1, 0.5};
  const auto usb = rumbleReport(PadKind::kDualSense, rumble, 1);
  ASSERT_EQ(usb.size(), 48u);
  EXPECT_EQ(Bytes(usb.begin(), usb.begin() + 6), (Bytes{0x02, 0x03, 0, 128, 255, 0}));
  const auto bluetooth = rumbleReport(PadKind::kDualSenseBluetooth, rumble, 1);
  ASSERT_EQ(bluetooth.size(), 78u);
  EXPECT_EQ(Bytes(bluetooth.begin(), bluetooth.begin() + 8), (Bytes{0x31, 0x10, 0x10, 0x03, 0, 128, 255, 0}));
  EXPECT_EQ(Bytes(bluetooth.end() - 4, bluetooth.end()), (Bytes{0x9D, 0x75, 0x77, 0x36})) << "by zlib's crc32";

  EXPECT_EQ(rumbleReport(PadKind::kDualShock4, rumble, 1).size(), 32u);
  const auto ds4 = rumbleReport(PadKind::kDualShock4, rumble, 1);
  EXPECT_EQ(Bytes(ds4.begin(), ds4.begin() + 7), (Bytes{0x05, 0x01, 0, 0, 128, 255, 0}));
  const auto ds4b = rumbleReport(PadKind::kDualShock4Bluetooth, rumble, 1);
  ASSERT_EQ(ds4b.size(), 78u);
  EXPECT_EQ(Bytes(ds4b.begin(), ds4b.begin() + 9), (Bytes{0x11, 0xC0, 0, 0x01, 0, 0, 128, 255, 0}));
  EXPECT_EQ(Bytes(ds4b.end() - 4, ds4b.end()), (Bytes{0xA3, 0xC2, 0xC5, 0x53}));

  EXPECT_EQ(rumbleReport(PadKind::kXboxBluetooth, rumble, 1), (Bytes{3, 0x0F, 0, 0, 100, 50, 0xFF, 0, 0xEB}));
  EXPECT_EQ(rumbleReport(PadKind::kXboxBluetooth, {7, -1}, 1), (Bytes{3, 0x0F, 0, 0, 100, 0, 0xFF, 0, 0xEB}));
  EXPECT_EQ(rumbleReport(PadKind::kXboxBluetooth, {std::nan(""), 0}, 1)[4], 0) << "what is no number is rest";
}

class Pads : public OnTestbed {};

TEST_F(Pads, ShakeWhileTheyAreToldAndStandStillAtTheEnd) {
  bed_->plugIn(
      {.vendor = 0x054c, .product = 0x0ce6, .name = "DualSense", .interfaces = {{1, 5}}, .is_bluetooth = true});
  auto pad = RumblePad::open(0x054c, 0x0ce6);
  ASSERT_TRUE(pad) << pad.error().message();
  EXPECT_EQ((*pad)->kind(), PadKind::kDualSenseBluetooth);
  const auto began = steady_clock::now();
  int wishes = 0;
  while (steady_clock::now() < began + milliseconds(500)) {
    (*pad)->set({0.5 + 0.001 * (++wishes % 100), 0.25});
    std::this_thread::sleep_for(milliseconds(1));
  }
  const auto reports = bed_->written(0);
  EXPECT_GT(reports.size(), 5u);
  EXPECT_LE(reports.size(), 55u) << "at most 100 a second";
  for (const Bytes& report : reports) {
    ASSERT_EQ(report.size(), 78u);
    const std::uint32_t crc = padChecksum(std::span(report).first(74));
    EXPECT_EQ(report[74], crc & 255);
    EXPECT_EQ(report[5], 64);
  }
  // Nobody repeats the wish: a fault, a pause, a window that hangs.
  ASSERT_TRUE(until([&] { return bed_->lastWritten(0)[5] == 0 && bed_->lastWritten(0)[6] == 0; }));
  (*pad)->set({1, 1});
  ASSERT_TRUE(until([&] { return bed_->lastWritten(0)[6] == 255; }));
  pad->reset();
  EXPECT_EQ(bed_->lastWritten(0)[5], 0);
  EXPECT_EQ(bed_->lastWritten(0)[6], 0);
}

TEST_F(Pads, TwoAlikeAreNotToldApartByPlace) {
  bed_->plugIn({.vendor = 0x054c, .product = 0x09cc, .name = "Pad", .interfaces = {{1, 5}}});
  bed_->plugIn(
      {.vendor = 0x054c, .product = 0x09cc, .name = "Pad", .interfaces = {{1, 5}}, .port = 2, .first_node = 1});
  const auto two = RumblePad::open(0x054c, 0x09cc);
  ASSERT_FALSE(two);
  EXPECT_EQ(two.error().code, Error::Code::kBadValue);
  EXPECT_FALSE(RumblePad::open(0x045e, 0x0b13)) << "none of these";
}

}  // namespace
}  // namespace kerf
