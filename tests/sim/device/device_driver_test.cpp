#include "sim/device/device_driver.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "sim/device/arm_driver.h"
#include "sim/device/device_finder.h"
#include "sim/device/pad_kind.h"

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

// ---- The udev rule that is installed: who sits at the machine may open what a driver knows

// What the lines about hidraw nodes permit, each in one of two ways.
class UdevRule {
 public:
  UdevRule() {
    std::ifstream file(std::filesystem::path(KERF_SOURCE_DIR) / "assets/udev/70-kerf-hid.rules");
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
  bool permits(const HidInfo& info) const {
    if (info.is_bluetooth) return bluetooth_.contains(info.vendor);
    return std::any_of(lines_.begin(), lines_.end(), [&](const Line& line) {
      return line.vendor == info.vendor && (line.products.empty() || line.products.contains(info.product));
    });
  }
  std::set<int> vendors() const {
    std::set<int> out = bluetooth_;
    for (const Line& line : lines_) out.insert(line.vendor);
    return out;
  }

 private:
  struct Line {
    int vendor = 0;
    std::set<int> products;  // empty: all of them
  };
  static int numberOf(const std::string& digits) { return std::stoi(digits, nullptr, 16); }
  std::vector<Line> lines_;
  std::set<int> bluetooth_;
};

// A device that some driver knows by its ids, whatever its descriptor says.
bool isKnownById(const HidInfo& info) {
  const DeviceDriver* const driver = driverOf(info);
  return armDriverOf(info) || padKindOf(info) || (driver && !driver->needs_layout);
}

TEST(UdevRule, PermitsEveryIdOfTheDrivers) {
  const UdevRule rule;
  // Those of the rule, and one that a driver knows but the rule forgot would be of.
  std::set<int> vendors = rule.vendors();
  vendors.insert({0x046d, 0x256f, 0x1234, 0x16c0, 0x054c, 0x045e});
  const std::pair<int, int> usages[] = {{1, 8}, {1, 5}, {0xFF00, 1}, {0xFFAB, 0x200}};
  int space_mice = 0, others = 0;
  HidInfo info;
  for (const int vendor : vendors)
    for (int product = 0; product <= 0xFFFF; ++product)
      for (const bool is_bluetooth : {false, true})
        for (const auto& [page, usage] : usages) {
          info.vendor = static_cast<std::uint16_t>(vendor);
          info.product = static_cast<std::uint16_t>(product);
          info.is_bluetooth = is_bluetooth;
          info.usage_page = static_cast<std::uint16_t>(page);
          info.usage = static_cast<std::uint16_t>(usage);
          if (!isKnownById(info)) continue;
          const DeviceDriver* const driver = driverOf(info);
          const bool is_space_mouse = driver == findDriver("spacemouse");
          const bool never_by_bluetooth = vendor == 0x046d || vendor == 0x1234 || vendor == 0x16c0;
          if (is_bluetooth && never_by_bluetooth) continue;
          (is_space_mouse && !is_bluetooth ? space_mice : others) += 1;
          EXPECT_TRUE(rule.permits(info)) << std::hex << vendor << ":" << product << (is_bluetooth ? " bluetooth" : "");
        }
  EXPECT_EQ(space_mice, 22);
  EXPECT_GT(others, 10);

  HidInfo keyboard;
  keyboard.vendor = 0x046d;
  keyboard.product = 0xc31c;
  EXPECT_FALSE(rule.permits(keyboard)) << "not every device of a maker";
}

}  // namespace
}  // namespace kerf::device_driver_test
