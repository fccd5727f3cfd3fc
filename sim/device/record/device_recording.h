// A device's reports as a text file, for replay and bug reports.
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
// The driver of a force-feedback arm is a HID driver or "bridge"; its reports are the received messages: reports or
// datagrams. Forces to the arm are not recorded.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/device/hid/device_finder.h"
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

  const DeviceDriver* driver = nullptr;  ///< for a device with axes; null: an arm
  std::string arm;                       ///< language of an arm's messages, for findTakeHand(); empty: no arm
  std::string device;                    ///< "046d:c626 SpaceNavigator"
  std::vector<RecordedReport> reports;
};

/// @param file  for errors: path as the user gave it.
/// Errors: kBadFormat with the line; kUnsupported: a later version, or an unknown driver.
Expected<DeviceRecording> parseRecording(std::string_view text, const std::string& file = {});
/// Errors: as parseRecording(); kNotFound, kUnreadable.
Expected<DeviceRecording> readRecording(const std::filesystem::path& file);
/// Writes a temporary file beside it, syncs, renames.
Expected<void> writeRecording(const std::filesystem::path& file, const DeviceRecording& recording);

/// The readings after each report, by the driver of the recording. Takes reports of all interfaces.
/// None for an arm.
std::vector<DeviceReading> replayRecording(const DeviceRecording& recording);

struct RecordedHand {
  std::int64_t time_us = 0;
  HandFrame hand;
};
struct RecordedHands {
  std::vector<RecordedHand> hands;
  std::uint64_t refused = 0;  ///< malformed messages
};
/// The hands of an arm, as its transport gave them during the recording. None for other devices.
RecordedHands replayHands(const DeviceRecording& recording);

/// Collects reports until the file would reach its largest size. One thread at a time.
class DeviceTape {
 public:
  /// @param keeps_reports  false: only measures gaps.
  explicit DeviceTape(DeviceRecording head, bool keeps_reports = true)
      : recording_(std::move(head)), keeps_reports_(keeps_reports) {}
  /// Only counts reports that are longer than kLongestReport or exceed the file's size.
  void add(std::int64_t time_ns, int interface, std::span<const std::uint8_t> report);
  std::uint64_t lost() const { return lost_; }
  /// Time between reports, over all of them.
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
