// What a device has sent, report by report, as a text file: to look at again, and to send to who has no such device.
//
//   kerf-device 1
//   driver spacemouse
//   device 046d:c626 SpaceNavigator
//   0 0 01 0a 00 f6 ff 00 00
//   8012 0 02 00 00 e2 ff 00 00
//
// A line of a report: time since the first one, us; interface; bytes, hexadecimal. Times never go back. A line that
// begins with # is a comment. Read strictly.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/device/device_finder.h"

namespace kerf {

struct RecordedReport {
  std::int64_t time_us = 0;
  int interface = 0;
  std::vector<std::uint8_t> bytes;
  bool operator==(const RecordedReport&) const = default;
};

struct DeviceRecording {
  const DeviceDriver* driver = nullptr;
  static constexpr std::int64_t kLongestUs = 366LL * 24 * 3600 * 1'000'000;  ///< no report is later

  std::string device;  ///< "046d:c626 SpaceNavigator"
  std::vector<RecordedReport> reports;
};

/// @param file  for errors: path as the user gave it.
/// Errors: kBadFormat with the line; kUnsupported: a later version, or a driver that is not known.
Expected<DeviceRecording> parseRecording(std::string_view text, const std::string& file = {});
/// Errors: as parseRecording(); kNotFound, kUnreadable.
Expected<DeviceRecording> readRecording(const std::filesystem::path& file);
/// Written beside, synced, renamed.
Expected<void> writeRecording(const std::filesystem::path& file, const DeviceRecording& recording);

/// The readings after each report, by the driver of the recording. Reports of all interfaces are taken.
std::vector<DeviceReading> replayRecording(const DeviceRecording& recording);

}  // namespace kerf
