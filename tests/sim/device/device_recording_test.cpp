#include "sim/device/device_recording.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace kerf {
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
}  // namespace kerf
