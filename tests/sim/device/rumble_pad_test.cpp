// The motors of gamepads: bytes, checksums by zlib's crc32, and what is written in which moment.
#include "sim/device/rumble_pad.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/device/force_scene.h"

namespace kerf::rumble_pad_test {
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

TEST_F(Pads, AreToldAgainWhatTheyDidNotTake) {
  bed_->plugIn({.vendor = 0x054c, .product = 0x0ce6, .name = "DualSense", .interfaces = {{1, 5}}});
  auto pad = RumblePad::open(0x054c, 0x0ce6);
  ASSERT_TRUE(pad) << pad.error().message();
  ASSERT_TRUE(until([&] {
    (*pad)->set({1, 1});
    return !bed_->written(0).empty();
  }));
  const Bytes rest = rumbleReport(PadKind::kDualSense, {}, 0);
  bed_->loseWrites(0, [n = 0](const Bytes&) mutable { return n++ < 2; });
  EXPECT_TRUE(until([&] {
    (*pad)->set({});
    return lastWritten() == rest;
  })) << "two reports were lost";
  EXPECT_TRUE((*pad)->isConnected());
}

// A report of that many bytes: what it begins and ends with, zeros between.
Bytes whole(Bytes head, std::size_t size, const Bytes& tail = {}) {
  head.resize(size - tail.size());
  head.insert(head.end(), tail.begin(), tail.end());
  return head;
}

struct PadOnTheWire {
  const char* name;
  std::uint16_t vendor, product;
  bool is_bluetooth;
  Bytes shakes, rests;  // its first two reports: strong fully, weak half; nothing
};

class PadsOnTheWire : public OnTestbed, public testing::WithParamInterface<PadOnTheWire> {};

TEST_P(PadsOnTheWire, GetTheseBytesAndNoOthers) {
  const PadOnTheWire& what = GetParam();
  bed_->plugIn({.vendor = what.vendor,
                .product = what.product,
                .name = "Pad",
                .interfaces = {{1, 5}},
                .is_bluetooth = what.is_bluetooth});
  auto pad = RumblePad::open(what.vendor, what.product);
  ASSERT_TRUE(pad) << pad.error().message();
  ASSERT_TRUE(until([&] {
    (*pad)->set({1, 0.5});
    return !bed_->written(0).empty();
  }));
  EXPECT_EQ(bed_->written(0).front(), what.shakes);
  const PadKind kind = (*pad)->kind();
  pad->reset();

  // A busy machine may have let the wish grow old, and brought it anew: then its reports have other numbers.
  const std::vector<Bytes> reports = bed_->written(0);
  ASSERT_GE(reports.size(), 2u);
  EXPECT_EQ(reports.back(), rumbleReport(kind, {}, static_cast<std::uint8_t>(reports.size() - 1)));
  if (reports.size() == 2) {
    EXPECT_EQ(reports.back(), what.rests);
  }
}

// Checksums by zlib's crc32 over 0xA2 and the bytes.
INSTANTIATE_TEST_SUITE_P(
    All, PadsOnTheWire,
    testing::Values(PadOnTheWire{"DualSense", 0x054c, 0x0ce6, false, whole({0x02, 0x03, 0, 128, 255}, 48),
                                 whole({0x02, 0x03}, 48)},
                    PadOnTheWire{"DualSenseBluetooth", 0x054c, 0x0df2, true,
                                 whole({0x31, 0x00, 0x10, 0x03, 0, 128, 255}, 78, {0x34, 0x81, 0x4B, 0x4A}),
                                 whole({0x31, 0x10, 0x10, 0x03}, 78, {0x65, 0x90, 0x12, 0xEA})},
                    PadOnTheWire{"DualShock4", 0x054c, 0x05c4, false, whole({0x05, 0x01, 0, 0, 128, 255}, 32),
                                 whole({0x05, 0x01}, 32)},
                    PadOnTheWire{"DualShock4Bluetooth", 0x054c, 0x09cc, true,
                                 whole({0x11, 0xC0, 0, 0x01, 0, 0, 128, 255}, 78, {0xA3, 0xC2, 0xC5, 0x53}),
                                 whole({0x11, 0xC0, 0, 0x01}, 78, {0x8D, 0xF5, 0x2D, 0xE0})},
                    PadOnTheWire{"XboxBluetooth",
                                 0x045e,
                                 0x02e0,
                                 true,
                                 {0x03, 0x0F, 0, 0, 100, 50, 0xFF, 0x00, 0xEB},
                                 {0x03, 0x0F, 0, 0, 0, 0, 0xFF, 0x00, 0xEB}}),
    [](const auto& tested) { return tested.param.name; });

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
}  // namespace kerf::rumble_pad_test
