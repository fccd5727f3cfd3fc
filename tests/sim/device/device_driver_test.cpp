#include "sim/device/device_driver.h"

#include <gtest/gtest.h>

#include "sim/device/device_finder.h"

namespace kerf {
namespace {

HidInfo multiAxis(std::uint16_t vendor, std::uint16_t product) {
  HidInfo info;
  info.path = info.parent = "/dev/hidraw0";
  info.vendor = vendor;
  info.product = product;
  info.usage_page = 1;
  info.usage = 8;
  return info;
}

TEST(DeviceDriver, EachModelOfTheFamilyIsOneAndItsKeyboardIsNone) {
  const std::pair<int, const char*> models[] = {{0xc62e, "SpaceMouse Wireless, cable"},
                                                {0xc633, "SpaceMouse Enterprise"},
                                                {0xc635, "SpaceMouse Compact"},
                                                {0xc652, "Universal Receiver"}};
  for (const auto& [product, name] : models) {
    HidInfo info = multiAxis(0x256f, static_cast<std::uint16_t>(product));
    const DeviceDriver* const driver = driverOf(info);
    ASSERT_NE(driver, nullptr) << name;
    EXPECT_STREQ(driver->nameOf(info), name);
    info.usage = 6;
    EXPECT_EQ(driverOf(info), nullptr) << "a keyboard";
  }
  EXPECT_EQ(driverOf(multiAxis(0x046d, 0xc640)), nullptr) << "a NuLOOQ has no six axes";
  EXPECT_EQ(driverOf(multiAxis(0x256f, 0xc650)), nullptr) << "a CadMouse";
}

TEST(DeviceDriver, AnyReportGivesAxesWithinTheirRange) {
  const DeviceDriver& driver = *findDriver("spacemouse");
  DeviceReading reading;
  for (int high : {0x00, 0x01, 0x7F, 0x80, 0xFE, 0xFF}) {
    for (int id : {1, 2}) {
      std::vector<std::uint8_t> report(id == 1 ? 13 : 7, static_cast<std::uint8_t>(high));
      report[0] = static_cast<std::uint8_t>(id);
      ASSERT_EQ(takeReport(driver, report, 5, reading), ReportKind::kMotion);
      for (const double axis : reading.axes) EXPECT_LE(std::abs(axis), 1);
    }
  }
}

TEST(DeviceDriver, ABatteryKeepsNoOldMotionAlive) {
  const DeviceDriver& driver = *findDriver("spacemouse");
  DeviceReading reading;
  const std::uint8_t moved[] = {1, 0x5E, 0x01, 0, 0, 0, 0}, battery[] = {0x17, 50, 0};
  takeReport(driver, moved, 1'000'000, reading);
  takeReport(driver, battery, 200'000'000, reading);
  EXPECT_EQ(axesAt(driver, reading, 50'000'000)[0], 1);
  EXPECT_EQ(axesAt(driver, reading, 201'000'000)[0], 0);
  EXPECT_EQ(axesAt(driver, DeviceReading{}, 1)[0], 0);
}

// Report 1: X, Y of 16 bits, an accelerator, a hat, ten buttons; report 2: a battery of 0 to 255.
constexpr std::uint8_t kStick[] = {0x05, 0x01, 0x09, 0x04, 0xA1, 0x01, 0x85, 0x01, 0x09, 0x30, 0x09, 0x31, 0x16, 0x00,
                                   0x80, 0x26, 0xFF, 0x7F, 0x75, 0x10, 0x95, 0x02, 0x81, 0x02, 0x05, 0x02, 0x09, 0xC4,
                                   0x15, 0x00, 0x26, 0xFF, 0x03, 0x75, 0x0A, 0x95, 0x01, 0x81, 0x02, 0x05, 0x01, 0x09,
                                   0x39, 0x15, 0x01, 0x25, 0x08, 0x75, 0x04, 0x81, 0x42, 0x05, 0x09, 0x19, 0x01, 0x29,
                                   0x0A, 0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x0A, 0x81, 0x02, 0x85, 0x02, 0x05,
                                   0x06, 0x09, 0x20, 0x26, 0xFF, 0x00, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02, 0xC0};

TEST(Joystick, IsReadByItsDescriptor) {
  HidInfo info;
  info.usage_page = 1;
  info.usage = 4;
  const DeviceDriver* const driver = driverOf(info);
  ASSERT_EQ(driver, findDriver("joystick"));
  const auto layout = parseHidDescriptor(kStick);
  ASSERT_TRUE(layout) << layout.error().message();
  DeviceReading reading;
  // X all the way right, Y in the middle, accelerator 0x3FF, hat to the upper right (2), buttons 1 and 10.
  const std::uint8_t moved[] = {1, 0xFF, 0x7F, 0, 0, 0xFF, 0x4B, 0x80};
  EXPECT_EQ(takeReport(*driver, moved, 1, reading, *layout), ReportKind::kMotion);
  EXPECT_EQ(reading.axes[0], 1);
  EXPECT_NEAR(reading.axes[1], 0, 1e-4);
  EXPECT_EQ(reading.axes[4], 1) << "the accelerator";
  EXPECT_EQ(reading.buttons & 0x3FF, 0x201u);
  EXPECT_EQ(reading.buttons >> 60, 3u) << "up and right";
  EXPECT_EQ(axesAt(*driver, reading, 10'000'000'000)[0], 1) << "it says nothing while nothing moves";

  const std::uint8_t battery[] = {2, 128};
  EXPECT_EQ(takeReport(*driver, battery, 2, reading, *layout), ReportKind::kBattery);
  EXPECT_EQ(reading.battery_percent, 50);
  EXPECT_EQ(takeReport(*driver, std::span(moved).first(5), 3, reading, *layout), ReportKind::kMalformed);
  const std::uint8_t other[] = {9, 1, 2};
  EXPECT_EQ(takeReport(*driver, other, 3, reading, *layout), ReportKind::kUnknown);
  EXPECT_EQ(reading.axes[0], 1);
}

TEST(SonyPads, SayTheirBatteryOnACableAndByBluetooth) {
  HidInfo info;
  info.vendor = 0x054c;
  info.product = 0x0ce6;
  info.usage_page = 1;
  info.usage = 5;
  const DeviceDriver& sense = *driverOf(info);
  EXPECT_STREQ(sense.id, "dualsense");
  info.product = 0x09cc;
  info.is_bluetooth = true;
  const DeviceDriver& shock = *driverOf(info);
  EXPECT_STREQ(shock.id, "dualshock4");

  const auto reportOf = [](std::size_t size, std::uint8_t number, std::size_t first, std::size_t buttons,
                           std::size_t battery, std::uint8_t said) {
    std::vector<std::uint8_t> report(size);
    report[0] = number;
    report[first] = 255;
    report[buttons] = 0x18;  // the cross at rest, square
    report[battery] = said;
    return report;
  };
  struct Case {
    const DeviceDriver& driver;
    std::vector<std::uint8_t> report;
    int percent;
    bool is_charging;
  };
  const Case cases[] = {
      {sense, reportOf(64, 1, 1, 8, 53, 0x07), 75, false},  {sense, reportOf(78, 0x31, 2, 9, 54, 0x13), 35, true},
      {sense, reportOf(64, 1, 1, 8, 53, 0x20), 100, false}, {sense, reportOf(64, 1, 1, 8, 53, 0xF0), -1, false},
      {shock, reportOf(64, 1, 1, 5, 30, 0x14), 45, true},   {shock, reportOf(78, 0x11, 3, 7, 32, 0x08), 85, false}};
  for (const Case& one : cases) {
    DeviceReading reading;
    EXPECT_EQ(takeReport(one.driver, one.report, 1, reading), ReportKind::kMotion);
    EXPECT_EQ(reading.axes[0], 1);
    EXPECT_EQ(reading.buttons, 1u);
    EXPECT_EQ(reading.battery_percent, one.percent);
    EXPECT_EQ(reading.is_charging, one.is_charging);
  }
  DeviceReading reading;
  const std::vector<std::uint8_t> wrong(20, 1);
  EXPECT_EQ(takeReport(sense, wrong, 1, reading), ReportKind::kMalformed);
  EXPECT_EQ(takeReport(shock, wrong, 1, reading), ReportKind::kMalformed);
}

TEST(DeviceFinder, TwoOfOneModelOnTwoPortsAreTwo) {
  HidInfo a = multiAxis(0x256f, 0xc652), b = a, c = a;
  a.parent = b.parent = "/sys/usb/1-1";
  c.parent = "/sys/usb/1-2";
  a.interface = 1;
  b.path = "/dev/hidraw1";
  b.interface = 0;
  c.path = "/dev/hidraw2";
  const auto found = groupDevices({a, b, c});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].interfaces.size(), 2u);
  EXPECT_EQ(found[0].path(), "/dev/hidraw1") << "its first interface";
  EXPECT_EQ(chooseDevice(found, "/dev/hidraw0")->path(), "/dev/hidraw1") << "any of its paths names it";
}

TEST(DeviceFinder, ASerialThatTwoHaveNamesNone) {
  HidInfo a = multiAxis(0x256f, 0xc635), b = a;
  a.serial = b.serial = "0001";
  b.path = b.parent = "/dev/hidraw1";
  const auto chosen = chooseDevice(groupDevices({a, b}), "0001");
  ASSERT_FALSE(chosen);
  EXPECT_EQ(chosen.error().code, Error::Code::kBadValue);
}

}  // namespace
}  // namespace kerf
