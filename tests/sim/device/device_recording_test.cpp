#include "sim/device/record/device_recording.h"

#include <gtest/gtest.h>

#include "sim/device/arm/raw_arm.h"
#include "tests/support/temporary_folder.h"

namespace kerf::device_recording_test {
namespace {

const char* const kText =
    "kerf-device 1\n"
    "driver spacemouse\n"
    "device 046d:c626 SpaceNavigator\n"
    "# pushed to the right, turned, let go\n"
    "0 0 01 5e 01 00 00 00 00\n"
    "8000 0 02 00 00 00 00 a2 fe\n"
    "16000 0 03 01 00\n"
    "24000 0 42 00\n";

TEST(DeviceRecording, ReplaysTheSameReadingsFromTheFileBitForBit) {
  const TemporaryFolder folder;
  const auto read = parseRecording(kText);
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_TRUE(writeRecording(folder.path() / "a.txt", *read));
  const auto again = readRecording(folder.path() / "a.txt");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->reports, read->reports);
  EXPECT_EQ(again->device, "046d:c626 SpaceNavigator");

  const auto readings = replayRecording(*again);
  EXPECT_EQ(readings, replayRecording(*read));
  ASSERT_EQ(readings.size(), 4u);
  EXPECT_EQ(readings[3].axes, (std::array<double, 6>{1, 0, 0, 0, 0, 1}));
  EXPECT_EQ(readings[3].buttons, 1u);
  EXPECT_EQ(readings[3].unknown, 1u);
}

TEST(DeviceRecording, OfAnArmGivesItsHands) {
  HandFrame hand;
  hand.number = 7;
  hand.pose.translation = {1, -2, 3.5};
  const RawArmReport report = encodeRawHand(hand);
  DeviceRecording recording;
  recording.arm = "rawhid";
  recording.reports = {{0, 0, {report.begin(), report.end()}}, {1000, 0, {1, 2}}};
  EXPECT_TRUE(replayRecording(recording).empty());
  const RecordedHands replayed = replayHands(recording);
  ASSERT_EQ(replayed.hands.size(), 1u);
  EXPECT_EQ(replayed.refused, 1u);
  EXPECT_LT((replayed.hands[0].hand.pose.translation - hand.pose.translation).norm(), 1e-3);
}

TEST(DeviceRecording, ATapeTakesNoMoreThanAFileMayHold) {
  DeviceRecording head;
  head.driver = findDriver("spacemouse");
  head.device = "x";
  DeviceTape tape(head);
  const std::vector<std::uint8_t> longest(DeviceRecording::kLongestReport), longer(longest.size() + 1);
  tape.add(5'000, 0, longer);
  EXPECT_EQ(tape.lost(), 1u);
  tape.add(5'000, 0, longest);
  tape.add(12'000, 1, longest);
  EXPECT_EQ(tape.lost(), 1u);
  ASSERT_EQ(tape.recording().reports.size(), 2u);
  EXPECT_EQ(tape.recording().reports[1].time_us, 7) << "since the first one";
  EXPECT_EQ(tape.gaps().count(), 2u);
  EXPECT_NEAR(tape.gaps().maxMs(), 0.007, 1e-9);
  for (int n = 0; n < 1400; ++n) tape.add(20'000, 0, longest);
  EXPECT_GT(tape.lost(), 1u);
  std::size_t size = 0;
  for (const RecordedReport& report : tape.recording().reports) size += 3 * report.bytes.size();
  EXPECT_LE(size, DeviceRecording::kLargestFile);
}

TEST(DeviceRecording, WhatIsWrongIsNamedByItsLine) {
  const std::pair<const char*, const char*> wrong[] = {
      {"", "line 0"},
      {"kerf-device 2\n", "version 2"},
      {"kerf-device 1\ndriver pedal\n", "driver \"pedal\""},
      {"kerf-device 1\ndriver spacemouse\nname x\n", "line 3"},
      {"kerf-device 1\ndriver spacemouse\ndevice x\n0 0\n", "no bytes"},
      {"kerf-device 1\ndriver spacemouse\ndevice x\n0 0 1\n", "line 4: \"1\""},
      {"kerf-device 1\ndriver spacemouse\ndevice x\n0 0 0g\n", "\"0g\""},
      {"kerf-device 1\ndriver spacemouse\ndevice x\n-1 0 01\n", "\"-1\""},
      {"kerf-device 1\ndriver spacemouse\ndevice x\n5 0 01\n4 0 01\n", "4 us after 5 us"},
      {"kerf-device 1\ndriver spacemouse\ndevice x\n31622400000001 0 01\n", "\"31622400000001\""},
  };
  for (const auto& [text, found] : wrong) {
    const auto read = parseRecording(text, "x.txt");
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find(found), std::string::npos) << read.error().message();
  }
}

}  // namespace
}  // namespace kerf::device_recording_test
