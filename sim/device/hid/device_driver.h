// Drivers of HID devices: which interfaces they match, and how to read and write their reports. A driver is one source
// with one row; the list is in device_driver.cpp. Functions of their arguments alone: any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sim/device/frame/device_frame.h"
#include "sim/device/hid/hid_port.h"

namespace kerf {

/// The newest state of a device with axes. Axes: right, away from the person, up; then turning about them,
/// right-handed.
struct DeviceReading {
  std::int64_t time_ns = 0;      ///< CLOCK_MONOTONIC, arrival of the newest motion; 0: none yet
  std::uint64_t reports = 0;     ///< understood
  std::uint64_t unknown = 0;     ///< with a number that the driver does not know
  std::uint64_t malformed = 0;   ///< with a length that does not fit the number; not used
  std::array<double, 6> axes{};  ///< -1 to 1; 0: at rest
  std::uint64_t buttons = 0;     ///< bit n: button n + 1 is down
  int battery_percent = -1;      ///< -1: not reported
  bool is_charging = false;
  bool operator==(const DeviceReading&) const = default;
};

enum class ReportKind { kMotion, kButtons, kBattery, kUnknown, kMalformed };

/// A report for the device, its number first.
using OutputReport = std::vector<std::uint8_t>;

/// A device with axes. All references: a row that lacks one does not compile.
struct AxesDriver {
  /// Reads a report. @rt safe. Counts nothing.
  /// @param report  as HidPort::read() gives it.   @param reading  keeps every value that the report does not carry.
  ReportKind (&take)(std::span<const std::uint8_t> report, DeviceReading& reading) noexcept;
  /// Reports that switch the light of the device.
  std::vector<OutputReport> (&light)(const HidInfo& info, bool is_lit);
};

/// Reads the hand of a force-feedback arm from one message: a HID report or a datagram. Units: device_frame.h. @rt
/// safe.
/// @return  anything but kNone: the message is invalid, `hand` keeps its value.
using TakeHand = FrameFault(std::span<const std::uint8_t> message, HandFrame& hand) noexcept;

inline constexpr std::size_t kLongestArmReport = 65;  ///< bytes to write, the report's number first
using ArmReportBytes = std::array<std::uint8_t, kLongestArmReport>;

/// A force-feedback arm. Each force report must carry its deadline: the arm gives no force after it.
struct ArmDriver {
  TakeHand& take;
  /// Writes the report for a force. @rt safe.   @return  its length in bytes.
  std::size_t (&write)(const ForceFrame& force, ArmReportBytes& out) noexcept;
};

struct DeviceDriver {
  const char* id;      ///< "spacemouse"
  const char* people;  ///< its purpose, for people
  /// Name of the device for people; null if the driver does not match.
  const char* (&nameOf)(const HidInfo& info);
  const AxesDriver* axes;  ///< one of the two; null for the other kind
  const ArmDriver* arm;
};

std::span<const DeviceDriver* const> deviceDrivers();
/// Null if no driver matches.
const DeviceDriver* driverOf(const HidInfo& info);
/// By its id. Null if there is none.
const DeviceDriver* findDriver(std::string_view id);
/// @param language  id of an arm's driver, or "bridge". Null for any other.
TakeHand* findTakeHand(std::string_view language);

/// Reads a report with the driver, counts it, keeps its time. @rt safe.   @pre driver.axes
ReportKind takeReport(const DeviceDriver& driver, std::span<const std::uint8_t> report, std::int64_t time_ns,
                      DeviceReading& reading) noexcept;

/// After this time without a motion report, s, the axes are at rest: devices repeat a motion every 8 ms.
inline constexpr double kSilence = 0.1;
/// The axes now: zero before the first report and after kSilence. @rt safe.
std::array<double, 6> axesAt(const DeviceReading& reading, std::int64_t now_ns) noexcept;

/// CLOCK_MONOTONIC, ns. @rt safe.
std::int64_t deviceClock() noexcept;

}  // namespace kerf
