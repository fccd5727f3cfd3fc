#include "sim/device/hid/device_driver.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "sim/device/hid/device_finder.h"
#include "tests/support/places.h"

namespace kerf::device_driver_test {
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
  EXPECT_EQ(axesAt(reading, 50'000'000)[0], 1);
  EXPECT_EQ(axesAt(reading, 201'000'000)[0], 0);
  EXPECT_EQ(axesAt(DeviceReading{}, 1)[0], 0);
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

// ---- The installed udev rule: the local user may open the devices of all drivers

// Permissions from the lines about hidraw nodes, each in one of two forms.
class UdevRule {
 public:
  UdevRule() {
    std::ifstream file(std::filesystem::path(kSourceFolder) / "assets/udev/70-kerf-hid.rules");
    const std::regex vendor(R"~(ATTRS\{idVendor\}=="([0-9a-f]{4})")~");
    const std::regex product(R"~(ATTRS\{idProduct\}=="([0-9a-f|]+)")~");
    const std::regex bluetooth(R"~(KERNELS=="0005:([0-9A-F]{4}):\*")~");
    for (std::string line; std::getline(file, line);) {
      if (!line.starts_with(R"(KERNEL=="hidraw*")") || line.find(R"(TAG+="uaccess")") == line.npos) continue;
      std::smatch found;
      if (std::regex_search(line, found, bluetooth)) {
        bluetooth_.insert(numberOf(found[1]));
        continue;
      }
      if (!std::regex_search(line, found, vendor)) continue;
      Line& permits = lines_.emplace_back();
      permits.vendor = numberOf(found[1]);
      if (!std::regex_search(line, found, product)) continue;
      std::istringstream products(found[1]);
      for (std::string one; std::getline(products, one, '|');) permits.products.insert(numberOf(one));
    }
  }
  bool permits(const HidInfo& info, bool is_bluetooth) const {
    if (is_bluetooth) return bluetooth_.contains(info.vendor);
    return std::any_of(lines_.begin(), lines_.end(), [&](const Line& line) {
      return line.vendor == info.vendor && (line.products.empty() || line.products.contains(info.product));
    });
  }

 private:
  struct Line {
    int vendor = 0;
    std::set<int> products;  // empty: all products
  };
  static int numberOf(const std::string& digits) { return std::stoi(digits, nullptr, 16); }
  std::vector<Line> lines_;
  std::set<int> bluetooth_;
};

TEST(UdevRule, PermitsEveryIdOfTheDrivers) {
  const UdevRule rule;
  int space_mice = 0;
  for (const int vendor : {0x046d, 0x256f})
    for (int product = 0; product <= 0xFFFF; ++product) {
      const HidInfo info = multiAxis(static_cast<std::uint16_t>(vendor), static_cast<std::uint16_t>(product));
      if (!driverOf(info)) continue;
      ++space_mice;
      EXPECT_TRUE(rule.permits(info, false)) << std::hex << vendor << ":" << product;
      if (vendor == 0x256f) {
        EXPECT_TRUE(rule.permits(info, true)) << std::hex << product;
      }
    }
  EXPECT_EQ(space_mice, 22);

  HidInfo keyboard;
  keyboard.vendor = 0x046d;
  keyboard.product = 0xc31c;
  EXPECT_FALSE(rule.permits(keyboard, false)) << "not every device of a maker";
}

}  // namespace
}  // namespace kerf::device_driver_test
