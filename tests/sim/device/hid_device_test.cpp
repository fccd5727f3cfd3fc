// The system's hidapi against simulated devices: everything except the wire. Skipped where umockdev is not preloaded.
#include "sim/device/hid/hid_device.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "sim/device/hid/device_watch.h"
#include "tests/support/hid_testbed.h"

namespace kerf::hid_device_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

const Bytes kRight{1, 0x5E, 0x01, 0, 0, 0, 0};   // 350 to the right
const Bytes kTurned{2, 0, 0, 0, 0, 0xA2, 0xFE};  // -350 about Z, down
const Bytes kRest{1, 0, 0, 0, 0, 0, 0};
const Bytes kBoth{1, 0xAF, 0, 0x51, 0xFF, 0, 0, 0, 0, 0, 0, 0x5E, 0x01};  // 175, -175, 0; 0, 0, 350

template <class Condition>
bool until(const Condition& holds, int most_ms = 3000) {
  const auto end = steady_clock::now() + milliseconds(most_ms);
  while (steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(milliseconds(1));
  }
  return holds();
}

class HidDevices : public testing::Test {
 protected:
  void SetUp() override {
    if (!HidTestbed::isThere()) GTEST_SKIP() << "umockdev is not preloaded: run umockdev-wrapper kerf_device_tests";
    bed_ = std::make_unique<HidTestbed>();
  }
  std::unique_ptr<HidDevice> openOnly() {
    auto found = chooseDevice(findDevices(), "");
    EXPECT_TRUE(found) << found.error().message();
    auto device = HidDevice::open(*found);
    EXPECT_TRUE(device) << device.error().message();
    return std::move(*device);
  }
  std::unique_ptr<HidTestbed> bed_;
};

TEST_F(HidDevices, AreFoundByPathAndSerialAndOthersAreLeftAlone) {
  bed_->plugIn({.serial = "A-17"});
  bed_->plugIn({.vendor = 0x256f, .product = 0xc635, .name = "SpaceMouse Compact", .port = 2, .first_node = 1});
  bed_->plugIn({.vendor = 0x1234, .product = 0x5678, .name = "Other", .port = 3, .first_node = 2});
  bed_->plugIn({.interfaces = {{1, 6}}, .port = 4, .first_node = 3});

  const std::vector<FoundDevice> found = findDevices();
  ASSERT_EQ(found.size(), 2u) << "a keyboard of the same id is none";
  EXPECT_EQ(found[0].name, "SpaceNavigator");
  EXPECT_EQ(found[0].path(), "/dev/hidraw0");
  EXPECT_EQ(found[0].serial(), "A-17");
  EXPECT_EQ(found[1].name, "SpaceMouse Compact");
  EXPECT_TRUE(found[0].mayOpen());

  EXPECT_EQ(chooseDevice(found, "A-17")->path(), "/dev/hidraw0");
  EXPECT_EQ(chooseDevice(found, "/dev/hidraw1")->name, "SpaceMouse Compact");
  const auto two = chooseDevice(found, "");
  ASSERT_FALSE(two);
  EXPECT_NE(two.error().message().find("/dev/hidraw0 (serial A-17), /dev/hidraw1"), std::string::npos)
      << two.error().message();
  const auto none = chooseDevice(found, "/dev/hidraw9");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Error::Code::kNotFound);
}

TEST_F(HidDevices, BothFormatsOfMotionAreTakenReportByReport) {
  bed_->plugIn({});
  const auto device = openOnly();
  bed_->send(0, kRight);
  bed_->send(0, kTurned);
  ASSERT_TRUE(until([&] { return device->axes() == std::array<double, 6>{1, 0, 0, 0, 0, 1}; }))
      << "down is negative: turned about up";
  bed_->send(0, kBoth);
  ASSERT_TRUE(until([&] { return device->axes() == std::array<double, 6>{0.5, 0.5, 0, 0, 0, -1}; }));
  EXPECT_EQ(device->reading().reports, 3u);
}

TEST_F(HidDevices, SilenceIsRest) {
  bed_->plugIn({});
  const auto device = openOnly();
  bed_->send(0, kRight);
  ASSERT_TRUE(until([&] { return device->axes()[0] == 1; }));
  const auto began = steady_clock::now();
  ASSERT_TRUE(until([&] { return device->axes()[0] == 0; }));
  const auto took = std::chrono::duration<double>(steady_clock::now() - began).count();
  EXPECT_GT(took, 0.5 * kSilence);
  EXPECT_LT(took, 2 * kSilence);
  EXPECT_EQ(device->reading().axes[0], 1) << "what it said is kept";
}

TEST_F(HidDevices, TheNewestOfManyReportsCountsAndNoneIsTorn) {
  bed_->plugIn({});
  const auto device = openOnly();
  for (int n = 1; n <= 300; ++n)
    bed_->send(0, {1, static_cast<std::uint8_t>(n & 255), static_cast<std::uint8_t>(n >> 8), 0, 0, 0, 0});
  ASSERT_TRUE(until([&] { return device->update() && device->reading().reports == 300; }, 10000));
  EXPECT_DOUBLE_EQ(device->reading().axes[0], 300 / 350.0);
  EXPECT_EQ(device->reading().malformed, 0u);
}

TEST_F(HidDevices, PartialAndUnknownReportsAreCountedAndNothingOfThemIsUsed) {
  bed_->plugIn({});
  const auto device = openOnly();
  bed_->send(0, {1, 0x5E, 0x01, 0, 0});
  bed_->send(0, {1, 0x5E, 0x01, 0, 0, 0, 0, 0});
  bed_->send(0, {2, 0x5E});
  bed_->send(0, {0x17, 200, 0});
  bed_->send(0, {0x42, 1, 2, 3});
  bed_->send(0, {3, 2, 0});
  ASSERT_TRUE(until([&] { return device->update() && device->reading().reports == 1; }));
  EXPECT_EQ(device->reading().malformed, 4u);
  EXPECT_EQ(device->reading().unknown, 1u);
  EXPECT_EQ(device->reading().axes, (std::array<double, 6>{}));
  EXPECT_EQ(device->reading().buttons, 2u);
  EXPECT_EQ(device->reading().battery_percent, -1);
}

TEST_F(HidDevices, ButtonsComeAsBitsOrAsNumbersAndTheBatteryToo) {
  bed_->plugIn({});
  const auto device = openOnly();
  bed_->send(0, {3, 0x02, 0, 0x40, 0x01});
  ASSERT_TRUE(until([&] { return device->update() && device->reading().reports == 1; }));
  EXPECT_EQ(device->reading().buttons, 0x01400002u);
  bed_->send(0, {0x1C, 3, 0, 24, 0});
  bed_->send(0, {0x17, 83, 1});
  ASSERT_TRUE(until([&] { return device->update() && device->reading().reports == 3; }));
  EXPECT_EQ(device->reading().buttons, (1u << 2) | (1u << 23));
  EXPECT_EQ(device->reading().battery_percent, 83);
  EXPECT_TRUE(device->reading().is_charging);
}

TEST_F(HidDevices, OfAReceiverTheInterfaceThatMovesIsKept) {
  const SimulatedHid receiver{.vendor = 0x256f,
                              .product = 0xc652,
                              .name = "Universal Receiver",
                              .interfaces = {{1, 8}, {1, 8}, {1, 6}, {1, 2}}};
  bed_->plugIn(receiver);
  const auto found = findDevices();
  ASSERT_EQ(found.size(), 1u) << "one device, whatever its interfaces";
  EXPECT_EQ(found[0].interfaces.size(), 2u) << "its keyboard and mouse are not opened";

  const auto device = openOnly();
  bed_->send(1, kBoth);
  ASSERT_TRUE(until([&] { return device->axes()[5] == -1; })) << "it talks on the second";
  bed_->send(0, kRight);
  bed_->send(1, kBoth);
  ASSERT_TRUE(until([&] { return device->update() && device->reading().reports >= 2; }));
  EXPECT_EQ(device->reading().axes[0], 0.5) << "the other one does not count while this one moves";
  std::this_thread::sleep_for(milliseconds(static_cast<int>(1500 * kSilence)));
  bed_->send(0, kRight);
  EXPECT_TRUE(until([&] { return device->axes()[0] == 1; })) << "but after its silence";
}

TEST_F(HidDevices, TheLightGoesOnWithTheDeviceAndOffAtItsEnd) {
  const SimulatedHid compact{.vendor = 0x256f, .product = 0xc635, .name = "SpaceMouse Compact"};
  bed_->plugIn(compact);
  auto device = openOnly();
  ASSERT_TRUE(until([&] { return bed_->written(0).size() == 1; }));
  EXPECT_EQ(bed_->written(0)[0], (Bytes{4, 1}));
  device.reset();
  EXPECT_EQ(bed_->written(0), (std::vector<Bytes>{{4, 1}, {4, 1}, {4, 0}})) << "this model goes dark from lit alone";
}

TEST_F(HidDevices, UnpluggedWhileItMovesItIsAtRestAndPluggedInAgainItIsFound) {
  bed_->plugIn({});
  DeviceWatch watch("", 20);
  ASSERT_TRUE(until([&] { return watch.device() != nullptr; })) << watch.trouble();
  const std::shared_ptr<HidDevice> first = watch.device();
  bed_->send(0, kRight);
  ASSERT_TRUE(until([&] { return first->axes()[0] == 1; }));

  bed_->unplug({});
  const auto began = steady_clock::now();
  ASSERT_TRUE(until([&] { return first->axes()[0] == 0; }));
  EXPECT_LT(steady_clock::now() - began, milliseconds(90)) << "sooner than by silence";
  ASSERT_TRUE(until([&] { return !first->isConnected() && !watch.device(); }));
  EXPECT_EQ(watch.trouble(), "");

  bed_->plugIn({.port = 2, .first_node = 5});
  ASSERT_TRUE(until([&] { return watch.device() != nullptr; }));
  bed_->send(5, kTurned);
  EXPECT_TRUE(until([&] { return watch.device()->axes()[5] == 1; }));
}

TEST_F(HidDevices, AListenerHearsEveryReportAsItCame) {
  bed_->plugIn({});
  const auto found = chooseDevice(findDevices(), "");
  std::mutex mutex;
  std::vector<Bytes> heard;
  {
    const auto device = HidDevice::open(*found, [&](std::int64_t, int, std::span<const std::uint8_t> report) {
      const std::lock_guard lock(mutex);
      heard.emplace_back(report.begin(), report.end());
    });
    ASSERT_TRUE(device);
    for (const Bytes& b : {kRight, kTurned, Bytes{0x42}, kRest}) bed_->send(0, b);
    EXPECT_TRUE(until([&] {
      const std::lock_guard lock(mutex);
      return heard.size() == 4;
    }));
  }
  EXPECT_EQ(heard, (std::vector<Bytes>{kRight, kTurned, {0x42}, kRest}));
}

TEST_F(HidDevices, AWriteThatIsStuckKeepsNoReportFromComing) {
  bed_->plugIn({});
  const auto found = chooseDevice(findDevices(), "");
  bed_->holdWrites(0, true);
  const auto device = HidDevice::open(*found);
  ASSERT_TRUE(device);
  ASSERT_TRUE(until([&] { return bed_->heldWrites(0) == 1; })) << "its light";
  bed_->send(0, kRight);
  EXPECT_TRUE(until([&] { return (*device)->axes()[0] == 1; }));
  EXPECT_EQ(bed_->heldWrites(0), 1u) << "still stuck";
  bed_->holdWrites(0, false);
}

TEST_F(HidDevices, OfSeveralNoneIsTakenByItsPlace) {
  bed_->plugIn({.serial = "A"});
  bed_->plugIn({.serial = "B", .port = 2, .first_node = 1});
  const DeviceWatch any("", 20);
  ASSERT_TRUE(until([&] { return !any.trouble().empty(); }));
  EXPECT_EQ(any.device(), nullptr);
  EXPECT_NE(any.trouble().find("/dev/hidraw0 (serial A), /dev/hidraw1 (serial B)"), std::string::npos) << any.trouble();
  const DeviceWatch named("B", 20);
  ASSERT_TRUE(until([&] { return named.device() != nullptr; })) << named.trouble();
  EXPECT_EQ(named.device()->what().path(), "/dev/hidraw1");
}

}  // namespace
}  // namespace kerf::hid_device_test
