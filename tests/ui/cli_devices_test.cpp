// kerf devices, run as a user does, with devices simulated by umockdev.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include "sim/device/arm/raw_arm.h"
#include "tests/support/hid_testbed.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf::cli_devices_test {
namespace {

using std::chrono::milliseconds;

const Bytes kRight{1, 0x5E, 0x01, 0, 0, 0, 0};   // 350 to the right
const Bytes kTurned{2, 0, 0, 0, 0, 0xA2, 0xFE};  // -350 about Z, down

struct Printed {
  int code = -1;
  std::string text;
};
Printed kerfSays(const std::string& arguments, const std::string& by = "timeout 60 ") {
  Printed out;
  FILE* const pipe = ::popen((by + std::string(kProgramFolder) + "/kerf " + arguments + " 2>&1").c_str(), "r");
  std::array<char, 4096> part{};
  while (const std::size_t size = std::fread(part.data(), 1, part.size(), pipe)) out.text.append(part.data(), size);
  out.code = WEXITSTATUS(::pclose(pipe));
  return out;
}

class DevicesCommand : public testing::Test {
 protected:
  void SetUp() override {
    if (!HidTestbed::isThere()) GTEST_SKIP() << "umockdev is not preloaded: run umockdev-wrapper before this";
    bed_ = std::make_unique<HidTestbed>();
  }
  std::unique_ptr<HidTestbed> bed_;
};

TEST_F(DevicesCommand, APermissionThatIsMissingNamesTheUdevRule) {
  const std::string nobody = "timeout 60 setpriv --reuid 65534 --regid 65534 --clear-groups ";
  if (kerfSays("--version", nobody).code != 0) GTEST_SKIP() << "only root can run kerf without its rights";
  bed_->plugIn({});
  ASSERT_EQ(::chmod(bed_->realPath(0).c_str(), 0600), 0);
  bed_->letOthersLook();

  const Printed list = kerfSays("devices", nobody);
  EXPECT_EQ(list.code, 0);
  EXPECT_NE(list.text.find("/dev/hidraw0: SpaceNavigator"), std::string::npos) << list.text;
  EXPECT_NE(list.text.find("scripts/setup --udev (udev rule 70-kerf-hid.rules)"), std::string::npos) << list.text;
  const Printed probed = kerfSays("devices --probe --for 1", nobody);
  EXPECT_EQ(probed.code, 1);
  EXPECT_NE(probed.text.find("/dev/hidraw0: no permission to open the device"), std::string::npos) << probed.text;
  EXPECT_NE(probed.text.find("70-kerf-hid.rules"), std::string::npos) << probed.text;
}

TEST_F(DevicesCommand, TheProgramListsProbesRecordsAndReplays) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "mine.txt").string();
  bed_->plugIn({.serial = "A-17"});
  const Printed list = kerfSays("devices");
  EXPECT_EQ(list.code, 0);
  EXPECT_NE(list.text.find("/dev/hidraw0: SpaceNavigator"), std::string::npos) << list.text;
  EXPECT_NE(list.text.find("serial A-17, driver spacemouse"), std::string::npos) << list.text;

  std::atomic<bool> is_over{false};
  std::thread hand([&] {
    for (int n = 0; !is_over; ++n) {
      bed_->send(0, n % 2 ? kTurned : kRight);
      std::this_thread::sleep_for(milliseconds(8));
    }
  });
  const Printed probed = kerfSays("devices A-17 --probe --for 1.5 --record " + file);
  is_over = true;
  hand.join();
  EXPECT_EQ(probed.code, 0) << probed.text;
  EXPECT_NE(probed.text.find("right +1.00 away +0.00 up +0.00, turned +0.00 +0.00 +1.00"), std::string::npos)
      << probed.text;
  EXPECT_NE(probed.text.find("written: " + file), std::string::npos) << probed.text;
  EXPECT_EQ(bed_->written(0).back(), (Bytes{4, 0})) << "dark again";

  const Printed replayed = kerfSays("devices --replay " + file);
  EXPECT_EQ(replayed.code, 0);
  EXPECT_NE(replayed.text.find("046d:c626 SpaceNavigator, driver spacemouse"), std::string::npos) << replayed.text;
  EXPECT_NE(replayed.text.find("turned +0.00 +0.00 +1.00"), std::string::npos) << replayed.text;
}

TEST_F(DevicesCommand, UnpluggedWhileItIsRecordedTheRecordingIsWritten) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "mine.txt").string();
  bed_->plugIn({});
  std::thread hand([&] {
    for (int n = 0; n < 100; ++n) {
      bed_->send(0, kRight);
      std::this_thread::sleep_for(milliseconds(8));
    }
    bed_->unplug({});
  });
  const Printed recorded = kerfSays("devices --for 20 --record " + file);
  hand.join();
  EXPECT_EQ(recorded.code, 1);
  EXPECT_NE(recorded.text.find("the device was unplugged"), std::string::npos) << recorded.text;
  EXPECT_NE(recorded.text.find("written: " + file), std::string::npos) << recorded.text;
  EXPECT_EQ(kerfSays("devices --replay " + file).code, 0);
}

TEST_F(DevicesCommand, AnArmIsProbedWithoutForceRecordedAndReplayed) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "arm.txt").string();
  bed_->plugIn({.vendor = 0xCAFE, .product = 0x4004, .name = "My arm", .serial = "R-1", .interfaces = {{0xFF4B, 1}}});
  std::atomic<bool> is_over{false};
  std::thread firmware([&] {
    HandFrame hand;
    for (hand.number = 1; !is_over; ++hand.number) {
      hand.pose.translation = {5, 0, 0.01 * static_cast<double>(hand.number % 100)};
      hand.velocity = {0, 0, 10};
      hand.buttons = 2;
      const RawArmReport report = encodeRawHand(hand);
      bed_->send(0, Bytes(report.begin(), report.end()));
      std::this_thread::sleep_for(milliseconds(1));
    }
  });
  const Printed probed = kerfSays("devices R-1 --probe --for 1.5 --record " + file);
  const Printed json = kerfSays("devices --probe --for 0.5 --json");
  is_over = true;
  firmware.join();
  EXPECT_EQ(probed.code, 0) << probed.text;
  EXPECT_NE(probed.text.find("RawHID arm, /dev/hidraw0: no force while it is probed"), std::string::npos)
      << probed.text;
  EXPECT_NE(probed.text.find("at +5.00 +0.00 "), std::string::npos) << probed.text;
  EXPECT_NE(probed.text.find("+0.0 +0.0 +10.0 mm/s"), std::string::npos) << probed.text;
  EXPECT_NE(probed.text.find(" b2"), std::string::npos) << probed.text;
  EXPECT_NE(probed.text.find(" ms old"), std::string::npos) << probed.text;
  EXPECT_NE(probed.text.find("written: " + file), std::string::npos) << probed.text;
  EXPECT_NE(json.text.find("\"force_N\": 0"), std::string::npos) << json.text;

  const std::vector<Bytes> written = bed_->written(0);
  EXPECT_FALSE(written.empty());
  for (const Bytes& report : written) {
    ForceFrame force;
    ASSERT_EQ(decodeRawForce(std::span(report).subspan(1), force), FrameFault::kNone);
    EXPECT_FALSE(force.is_enabled);
    EXPECT_EQ(force.force, Vec3d::Zero());
  }
  const Printed replayed = kerfSays("devices --replay " + file);
  EXPECT_EQ(replayed.code, 0);
  EXPECT_NE(replayed.text.find("cafe:4004 RawHID arm, driver rawhid"), std::string::npos) << replayed.text;
  EXPECT_NE(replayed.text.find("at +5.00 +0.00 +0.50 mm, +0.0 +0.0 +10.0 mm/s"), std::string::npos)
      << replayed.text.substr(0, 2000);
  EXPECT_EQ(kerfSays("devices --replay " + file + " --json").text,
            kerfSays("devices --replay " + file + " --json").text);
}

TEST_F(DevicesCommand, AnArmIsListedByItsDriver) {
  bed_->plugIn({.vendor = 0xCAFE, .product = 0x4004, .name = "My arm", .serial = "R-1", .interfaces = {{0xFF4B, 1}}});
  bed_->plugIn({.port = 2, .first_node = 1});
  const Printed list = kerfSays("devices");
  EXPECT_EQ(list.code, 0);
  EXPECT_NE(list.text.find("/dev/hidraw0: RawHID arm, a force-feedback arm"), std::string::npos) << list.text;
  EXPECT_NE(list.text.find("serial R-1, driver rawhid"), std::string::npos) << list.text;
  EXPECT_NE(list.text.find("/dev/hidraw1: SpaceNavigator"), std::string::npos) << list.text;
  const Printed one = kerfSays("devices R-1 --json");
  EXPECT_NE(one.text.find("\"driver\": \"rawhid\""), std::string::npos) << one.text;
}

}  // namespace
}  // namespace kerf::cli_devices_test
