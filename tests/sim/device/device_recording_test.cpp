#include "sim/device/device_recording.h"

#include <gtest/gtest.h>

#include <fstream>

#include "sim/device/woody_arm.h"
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

// A joystick: its reports mean what the descriptor beside them says.
TEST(DeviceRecording, HoldsTheDescriptorThatItsReportsNeed) {
  const char* const text =
      "kerf-device 1\n"
      "driver joystick\n"
      "device 1209:ffb0 joystick\n"
      "descriptor 0 05 01 09 04 a1 01 09 30 15 00 26 ff 00 75 08 95 01 81 02 c0\n"
      "0 0 ff\n"
      "900000 0 00\n"
      "900001 1 00\n";
  const TemporaryFolder folder;
  const auto read = parseRecording(text);
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_TRUE(writeRecording(folder.path() / "a.txt", *read));
  std::ifstream in(folder.path() / "a.txt");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), text);

  const auto readings = replayRecording(*read);
  ASSERT_EQ(readings.size(), 3u);
  EXPECT_EQ(readings[0].axes[0], 1);
  EXPECT_EQ(readings[1].axes[0], -1);
  EXPECT_EQ(readings[2].unknown, 1u) << "an interface without a descriptor";
}

TEST(DeviceRecording, OfAnArmGivesItsHands) {
  const auto read = parseRecording(
      "kerf-device 1\ndriver serial\ndevice my arm\n"
      "0 0 5b 33 2c 30 2c 2d 33 30 30 30 2c 35 30 30 30 2c 30 2c 30 2c 30 2c 30 5d\n"
      "1000 0 5b 33\n");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->driver, nullptr);
  EXPECT_TRUE(replayRecording(*read).empty());
  const RecordedHands replayed = replayHands(*read);
  ASSERT_EQ(replayed.hands.size(), 1u);
  EXPECT_EQ(replayed.refused, 1u);
  // Counts of its motors from its home pose, where the third says -6000.
  EXPECT_EQ(replayed.hands[0].hand.pose.translation,
            woodyPose(serialWoody(), {0, -3000, 5000 - 6000, 0, 0, 0}).position);
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
      {"kerf-device 1\ndriver spacemouse\ndevice x\ndescriptor 0 c0\n", "a descriptor"},
      {"kerf-device 1\ndriver joystick\ndevice x\n0 0 01\ndescriptor 0 05 01\n", "a descriptor"},
      {"kerf-device 1\ndriver joystick\ndevice x\ndescriptor 0 c0\n", "did not begin"},
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
