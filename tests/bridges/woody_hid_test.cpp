// The WoodenHaptics bridge with an HID arm simulated by umockdev.
#include <gtest/gtest.h>

#include <cmath>

#include "bridges/woody_arm.h"
#include "tests/bridges/bridge_scene.h"
#include "tests/bridges/woody_firmware.h"
#include "tests/support/places.h"

namespace kerf::test {
namespace {

using bridge::woodyCurrents;
using bridge::woodyPose;

int wordAt(const Bytes& bytes, std::size_t at) { return static_cast<std::int16_t>(bytes[at] | (bytes[at + 1] << 8)); }

class WoodyHid : public OnTestbed {
 protected:
  void begin(bool is_teensy, const std::array<int, 3>& counts) {
    size_ = is_teensy ? 64 : 14;
    if (is_teensy)
      bed_->plugIn({.vendor = 0x16c0, .product = 0x486, .name = "Teensy", .interfaces = {{0xFFAB, 0x200}}});
    else
      bed_->plugIn(woody_);
    encoders_.emplace(*bed_, 0, counts, size_);
    talk([this](std::uint32_t) { return encoders_->report(); });
    kerf_ = openKerf();
    bridge_ = std::make_unique<Program>(std::vector<std::string>{std::string(kProgramFolder) + "/kerf-bridge-woody",
                                                                 HidTestbed::path(0), std::to_string(kerf_->port())});
    ASSERT_TRUE(until([&] { return kerf_->counts().hands > 10; }));
  }
  bool isReady() const {
    HandFrame hand;
    return kerf_->lastHand(hand) && hand.is_ready;
  }
  bool isFresh() const { return deviceClock() - kerf_->counts().newest_came_ns < 100'000'000; }
  bool hasCurrent() const {
    const Bytes last = lastWritten();
    return wordAt(last, 1) != 0 || wordAt(last, 3) != 0 || wordAt(last, 5) != 0;
  }

  const SimulatedHid woody_{.vendor = 0x1234, .product = 6, .name = "Woody", .interfaces = {{0xFF00, 1}}};
  std::size_t size_ = 14;
  std::optional<WoodyFirmware> encoders_;
  std::unique_ptr<BridgeDevice> kerf_;
  std::unique_ptr<Program> bridge_;
};

TEST_F(WoodyHid, OfBothLengthsIsCalibratedThenGetsCurrents) {
  for (const bool is_teensy : {false, true}) {
    bed_.reset();
    bed_ = std::make_unique<HidTestbed>();
    is_off_ = false;
    begin(is_teensy, {-200, 4100, 77});
    {
      const Pusher pusher(*kerf_, {0, 0, 1});
      ASSERT_TRUE(until([&] { return bed_->written(0).size() > 50; }));
      for (const Bytes& report : bed_->written(0)) EXPECT_EQ(report, Bytes(size_ + 1)) << "no force uncalibrated";
      EXPECT_FALSE(isReady());
      bridge_->pressEnter();
      ASSERT_TRUE(until([&] { return isReady(); }));

      encoders_->turn({0, 3000, -1000});
      const bridge::Vec3 currents = woodyCurrents(woodyPose({}, {0, 3000, 5000}), {0, 0, 1});
      ASSERT_TRUE(until([&] {
        const Bytes last = lastWritten();
        return std::abs(wordAt(last, 1) - currents[0]) <= 1 && std::abs(wordAt(last, 3) - currents[1]) <= 1 &&
               std::abs(wordAt(last, 5) - currents[2]) <= 1;
      }));
      EXPECT_EQ(lastWritten().size(), size_ + 1);
      EXPECT_EQ(bridge_->end(), 0);
    }
    EXPECT_EQ(lastWritten(), Bytes(size_ + 1)) << "no force at the end";
    is_off_ = true;
    firmware_.join();
  }
}

// Its encoders continue from the switch-on pose, so a force from them would point elsewhere.
TEST_F(WoodyHid, OneThatDoesNotTakeItsCalibrationIsGivenNoForce) {
  begin(false, {0, 0, 5900});
  encoders_->ignoreCalibration(true);
  const Pusher pusher(*kerf_, {0, 0, 1});
  bridge_->pressEnter();
  std::this_thread::sleep_for(std::chrono::milliseconds(1700));
  EXPECT_FALSE(isReady());
  for (const Bytes& report : bed_->written(0))
    for (const std::size_t motor : {1, 3, 5}) EXPECT_EQ(wordAt(report, motor), 0);
  encoders_->ignoreCalibration(false);
  bridge_->pressEnter();
  EXPECT_TRUE(until([&] { return hasCurrent(); }));
}

TEST_F(WoodyHid, CalibratingAgainIsNotReadyForLongEnoughToDisarmKerf) {
  begin(false, {0, 0, 5900});
  const Pusher pusher(*kerf_, {0, 0, 1});
  bridge_->pressEnter();
  ASSERT_TRUE(until([&] { return hasCurrent(); }));
  const auto begin = std::chrono::steady_clock::now();
  bridge_->pressEnter();
  EXPECT_TRUE(until([&] { return !isReady() && !pusher.is_valid && !hasCurrent(); }));
  EXPECT_TRUE(until([&] { return isReady(); }));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(1500));
}

// Its last report was near home. An old report is no calibration.
TEST_F(WoodyHid, ASilentArmIsNotCalibrated) {
  begin(false, {0, 0, 6000});
  is_silent_ = true;
  ASSERT_TRUE(until([&] { return !isFresh(); }));
  bridge_->pressEnter();
  std::this_thread::sleep_for(std::chrono::milliseconds(1700));
  is_silent_ = false;
  const std::uint64_t hands = kerf_->counts().hands;
  ASSERT_TRUE(until([&] { return kerf_->counts().hands > hands + 10; }));
  EXPECT_FALSE(isReady());
}

TEST_F(WoodyHid, GivesNoForceWithoutNewsOfKerfAndEndsWhenItIsUnplugged) {
  begin(false, {});
  bridge_->pressEnter();
  Pusher pusher(*kerf_, {0, 0, 1});
  ASSERT_TRUE(until([&] { return hasCurrent(); }));
  const auto gives = [](const Bytes& report) { return report != Bytes(report.size()); };
  EXPECT_LE(forcesAfter([&] { pusher.hangs = true; }, gives), kDeadMan);
  pusher.hangs = false;
  ASSERT_TRUE(until([&] { return hasCurrent(); }));
  bed_->unplug(woody_);
  EXPECT_EQ(bridge_->wait(), 1);
}

}  // namespace
}  // namespace kerf::test
