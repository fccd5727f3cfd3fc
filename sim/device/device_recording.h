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
//
// The driver of a force-feedback arm is a driver of HID or "bridge"; its reports are the messages that came: reports or
// datagrams. The forces that it was sent are not kept.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/device/device_finder.h"
#include "sim/live/time_histogram.h"

namespace kerf {

struct RecordedReport {
  std::int64_t time_us = 0;
  int interface = 0;
  std::vector<std::uint8_t> bytes;
  bool operator==(const RecordedReport&) const = default;
};

struct DeviceRecording {
  static constexpr std::int64_t kLongestUs = 366LL * 24 * 3600 * 1'000'000;  ///< no report is later
  static constexpr std::size_t kLongestReport = 1 << 16;                     ///< bytes
  static constexpr std::size_t kLargestFile = 256 << 20;                     ///< bytes: 20 minutes of an arm

  const DeviceDriver* driver = nullptr;  ///< of a device with axes; null: it is an arm
  std::string arm;                       ///< language of its messages, as findTakeHand() takes it; empty: no arm
  std::string device;                    ///< "046d:c626 SpaceNavigator"
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
/// None of an arm.
std::vector<DeviceReading> replayRecording(const DeviceRecording& recording);

struct RecordedHand {
  std::int64_t time_us = 0;
  HandFrame hand;
};
struct RecordedHands {
  std::vector<RecordedHand> hands;
  std::uint64_t refused = 0;  ///< messages that were malformed
};
/// The hands of an arm, as its transport gave them when they were recorded. None of anything else.
RecordedHands replayHands(const DeviceRecording& recording);

/// Reports as they come, until the file that they will be is as large as one may be. One thread at a time.
class DeviceTape {
 public:
  /// @param keeps_reports  else only how far apart they come.
  explicit DeviceTape(DeviceRecording head, bool keeps_reports = true)
      : recording_(std::move(head)), keeps_reports_(keeps_reports) {}
  /// What cannot be recorded, longer than kLongestReport or behind the end of a full file, is counted alone.
  void add(std::int64_t time_ns, int interface, std::span<const std::uint8_t> report);
  std::uint64_t lost() const { return lost_; }
  /// From each to the next, of all of them.
  const TimeHistogram& gaps() const { return gaps_; }
  const DeviceRecording& recording() const { return recording_; }

 private:
  DeviceRecording recording_;
  bool keeps_reports_;
  TimeHistogram gaps_;
  std::int64_t first_ns_ = 0, last_ns_ = 0;
  std::size_t size_ = 0;  // of the file, bytes
  std::uint64_t lost_ = 0;
};

}  // namespace kerf
