// Recorded arms and replays of the recordings: the same hands, bit for bit, from any transport.
#include "sim/device/record/replay_arm.h"

#include <gtest/gtest.h>

#include <map>

#include "bridges/simulated/arm_simulator.h"
#include "sim/device/arm/bridge_device.h"
#include "sim/device/arm/raw_arm.h"
#include "sim/device/record/device_recording.h"
#include "tests/sim/device/force_scene.h"
#include "tests/support/temporary_folder.h"

namespace kerf::replay_arm_test {
namespace {

using namespace test;

using HandBytes = std::array<std::uint8_t, kHandFrameSize>;

class ReplayedArms : public OnTestbed {
 protected:
  // Records a live arm and keeps its hands.
  void record(
      const std::string& name, const std::function<void(ForceArm&)>& begin = [](ForceArm&) {}) {
    std::mutex mutex;
    std::unique_ptr<DeviceTape> tape;
    std::string language;
    {
      DeviceRecording head;
      head.device = "x";
      tape = std::make_unique<DeviceTape>(head);
      auto opened = openArm(name, {}, {}, [&](std::int64_t t, std::span<const std::uint8_t> message) {
        const std::lock_guard lock(mutex);
        tape->add(t, 0, message);
      });
      ASSERT_TRUE(opened) << opened.error().message();
      language = opened->language;
      begin(*opened->arm);
      ASSERT_TRUE(until([&] {
        HandFrame hand;
        if (opened->arm->lastHand(hand)) live_[hand.number] = hand;
        return live_.size() >= 40;
      }));
      EXPECT_FALSE(opened->arm->counts().is_enabled) << "nobody enabled it";
    }
    DeviceRecording recording = tape->recording();
    recording.arm = language;
    ASSERT_TRUE(writeRecording(file(), recording));
  }
  std::string file() const { return (folder_.path() / "arm.txt").string(); }

  // Each observed hand is in the recording, unchanged.
  void expectSame() {
    const auto read = readRecording(file());
    ASSERT_TRUE(read) << read.error().message();
    const RecordedHands replayed = replayHands(*read);
    EXPECT_EQ(replayed.refused, 0u);
    std::size_t same = 0;
    for (const RecordedHand& one : replayed.hands) {
      const auto seen = live_.find(one.hand.number);
      if (seen == live_.end()) continue;
      EXPECT_EQ(encode(one.hand), encode(seen->second)) << one.hand.number;
      ++same;
    }
    EXPECT_EQ(same, live_.size());
    expectLeads(replayed);
  }

  // The recording in the place of the arm.
  void expectLeads(const RecordedHands& recorded) {
    std::map<std::uint64_t, HandBytes> of;
    for (const RecordedHand& one : recorded.hands) of[one.hand.number] = encode(one.hand);
    auto opened = openArm("replay:" + file(), {});
    ASSERT_TRUE(opened) << opened.error().message();
    ForceArm& arm = *opened->arm;
    arm.enable(true);
    HandFrame hand;
    ASSERT_TRUE(until([&] { return arm.lastHand(hand); }));
    EXPECT_EQ(encode(hand), of.begin()->second) << "it waits at its beginning";
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    ASSERT_TRUE(arm.lastHand(hand));
    EXPECT_EQ(hand.number, of.begin()->first);

    std::size_t seen = 0;
    {
      Pusher pusher(arm, {0, 0, 1});
      ASSERT_TRUE(until([&] {
        if (arm.lastHand(hand)) {
          EXPECT_EQ(encode(hand), of[hand.number]) << hand.number;
          ++seen;
        }
        return arm.isOver();
      }));
    }
    ASSERT_TRUE(arm.lastHand(hand));
    EXPECT_EQ(hand.number, of.rbegin()->first);
    EXPECT_GT(seen, 5u);
    EXPECT_EQ(arm.counts().forces, 0u);
    EXPECT_NE(arm.counts().trouble.find("over"), std::string::npos);
  }

  const TemporaryFolder folder_;
  std::map<std::uint64_t, HandFrame> live_;  // by number
};

CutPath aWay() {
  CutPath path;
  path.poses = {{0, {}}, {60, {Eigen::Quaterniond::Identity(), {3, -7, 11}}}};
  path.cuts = {1};
  return path;
}

TEST_F(ReplayedArms, OurOwnProfile) {
  bed_->plugIn(raw_);
  talk([](std::uint32_t number) {
    HandFrame hand;
    hand.number = number;
    hand.pose.translation = {0.1 * static_cast<double>(number % 7), 1.0 / 3, -2};
    const RawArmReport report = encodeRawHand(hand);
    return Bytes(report.begin(), report.end());
  });
  record("R-1");
  expectSame();
}

TEST_F(ReplayedArms, ABridge) {
  std::unique_ptr<ArmSimulator> bridge;
  record("udp:0", [&](ForceArm& arm) {
    auto started = ArmSimulator::start(aWay(), {.port = dynamic_cast<BridgeDevice&>(arm).port(), .hand = {}});
    ASSERT_TRUE(started);
    bridge = std::move(*started);
  });
  expectSame();
}

TEST(ReplayArm, WhatIsNoArmIsRefused) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "a.txt").string();
  DeviceRecording recording;
  recording.driver = findDriver("spacemouse");
  recording.device = "046d:c626 SpaceNavigator";
  ASSERT_TRUE(writeRecording(file, recording));
  const auto opened = openArm("replay:" + file, {});
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message().find("not a force-feedback arm"), std::string::npos) << opened.error().message();
  recording.driver = nullptr;
  recording.arm = "bridge";
  ASSERT_TRUE(writeRecording(file, recording));
  EXPECT_FALSE(openArm("replay:" + file, {})) << "no hand";
  EXPECT_FALSE(openArm("replay:" + file + "x", {})) << "no file";
}

}  // namespace
}  // namespace kerf::replay_arm_test
