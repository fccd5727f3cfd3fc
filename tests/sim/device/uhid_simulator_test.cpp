// The kernel's uhid as a plain file in its place: the bytes that make a device, its reports, and its end.
#include "sim/device/uhid_simulator.h"

#include <gtest/gtest.h>
#include <linux/uhid.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "sim/device/device_driver.h"
#include "tests/support/temporary_folder.h"

namespace kerf::uhid_simulator_test {
namespace {

// Of a packed struct no reference may be taken.
int typeOf(const uhid_event& event) { return static_cast<int>(event.type); }

class Uhid : public testing::Test {
 protected:
  void SetUp() override { std::ofstream(node_) << ""; }
  // All that was written while it ran for some reports.
  std::vector<uhid_event> eventsOf(UhidModel model) {
    {
      auto device = UhidSimulator::start(model, node_);
      EXPECT_TRUE(device) << device.error().message();
      if (!device) return {};
      const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
      while ((*device)->report().sent < 6 && std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      EXPECT_GE((*device)->report().sent, 6u);
    }
    std::vector<uhid_event> out(std::filesystem::file_size(node_) / sizeof(uhid_event));
    std::ifstream file(node_, std::ios::binary);
    file.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size() * sizeof(uhid_event)));
    EXPECT_EQ(std::filesystem::file_size(node_) % sizeof(uhid_event), 0u) << "whole events alone";
    return out;
  }
  const TemporaryFolder folder_;
  const std::filesystem::path node_ = folder_.path() / "uhid";
};

TEST_F(Uhid, ASpaceMouseIsMadeMovesAndIsUnplugged) {
  const std::vector<uhid_event> events = eventsOf(UhidModel::kSpaceMouse);
  ASSERT_GE(events.size(), 8u);
  ASSERT_EQ(typeOf(events.front()), UHID_CREATE2);
  const uhid_create2_req& made = events.front().u.create2;
  EXPECT_STREQ(reinterpret_cast<const char*>(made.name), "Simulated SpaceMouse");
  EXPECT_STREQ(reinterpret_cast<const char*>(made.uniq), "KERF-SIM");
  EXPECT_EQ(unsigned{made.bus}, 3u) << "USB";
  EXPECT_EQ(unsigned{made.vendor}, 0x256fu);
  EXPECT_EQ(unsigned{made.product}, 0xc62eu);
  const auto layout = parseHidDescriptor({made.rd_data, made.rd_size});
  ASSERT_TRUE(layout) << layout.error().message();

  // What it says its driver understands, and the descriptor has room for.
  const DeviceDriver& driver = *findDriver("spacemouse");
  DeviceReading reading;
  double farthest = 0;
  for (std::size_t n = 1; n + 1 < events.size(); ++n) {
    ASSERT_EQ(typeOf(events[n]), UHID_INPUT2) << n;
    const uhid_input2_req& said = events[n].u.input2;
    const ReportKind kind = takeReport(driver, {said.data, said.size}, 1, reading);
    EXPECT_EQ(kind, n % 2 == 1 ? ReportKind::kMotion : ReportKind::kButtons) << n;
    EXPECT_EQ(std::size_t{said.size}, layout->bytesOf(HidReportKind::kInput, said.data[0])) << n;
    farthest = std::max(farthest, std::abs(reading.axes[0]));
  }
  EXPECT_NEAR(farthest, 300.0 / 350, 0.01) << "it begins to the right";
  EXPECT_EQ(reading.malformed + reading.unknown, 0u);
  EXPECT_EQ(typeOf(events.back()), UHID_DESTROY);
}

TEST_F(Uhid, APadIsMadeRestsAndIsUnplugged) {
  const std::vector<uhid_event> events = eventsOf(UhidModel::kPad);
  ASSERT_GE(events.size(), 8u);
  const uhid_create2_req& made = events.front().u.create2;
  EXPECT_EQ(unsigned{made.bus}, 5u) << "Bluetooth";
  EXPECT_EQ(unsigned{made.vendor}, 0x045eu);
  EXPECT_EQ(unsigned{made.product}, 0x0b13u);
  const auto layout = parseHidDescriptor({made.rd_data, made.rd_size});
  ASSERT_TRUE(layout) << layout.error().message();
  EXPECT_EQ(layout->bytesOf(HidReportKind::kOutput, 3), 9u) << "that it is told to shake by";
  for (std::size_t n = 1; n + 1 < events.size(); ++n) {
    ASSERT_EQ(typeOf(events[n]), UHID_INPUT2) << n;
    EXPECT_EQ(std::size_t{events[n].u.input2.size}, 16u) << n;
    EXPECT_EQ(events[n].u.input2.data[0], 1) << n;
  }
  EXPECT_EQ(typeOf(events.back()), UHID_DESTROY);
}

TEST(UhidSimulator, WithoutUhidItSaysWhatToDo) {
  const auto none = UhidSimulator::start(UhidModel::kPad, "/dev/no-uhid");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Error::Code::kNotFound);
  EXPECT_NE(none.error().message().find("modprobe uhid"), std::string::npos) << none.error().message();
}

}  // namespace
}  // namespace kerf::uhid_simulator_test
