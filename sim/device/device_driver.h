// Drivers of HID devices: which devices they are for, and what their reports mean. A driver is one source with one row;
// the list is in device_driver.cpp. Functions of their arguments alone: any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sim/device/hid_descriptor.h"
#include "sim/device/hid_port.h"

namespace kerf {

/// What a device has said, newest. Axes: right, away from the person, up; then turning about them, right-handed. Of a
/// driver with names of its own for them (DeviceDriver::axes): those.
struct DeviceReading {
  std::int64_t time_ns = 0;      ///< CLOCK_MONOTONIC, when its newest report came; 0: none yet
  std::uint64_t reports = 0;     ///< that came and were understood
  std::uint64_t unknown = 0;     ///< of a number that the driver does not know
  std::uint64_t malformed = 0;   ///< of a length that does not fit its number; nothing of them is used
  std::array<double, 6> axes{};  ///< -1 to 1; 0: at rest
  std::uint64_t buttons = 0;     ///< bit n: button n + 1 is down
  int battery_percent = -1;      ///< -1: it did not say
  bool is_charging = false;
  bool operator==(const DeviceReading&) const = default;
};

enum class ReportKind { kMotion, kButtons, kBattery, kUnknown, kMalformed };

/// A report an interface is sent, its number first.
using OutputReport = std::vector<std::uint8_t>;

/// Names of axes for people, as DeviceReading has them; null: there is none, empty: named with the one before.
using AxisNames = std::array<const char*, 6>;

struct DeviceDriver {
  const char* id;               ///< "spacemouse"
  const char* people;           ///< what it is for, for people
  const AxisNames& axes;        ///< null: there is no such axis
  bool needs_layout;            ///< its reports mean what the descriptor of the device says
  bool is_at_rest_when_silent;  ///< else a report comes only when something changes, and the last one goes on to count
  /// Name of the device for people; null: the driver is not for it.
  const char* (&nameOf)(const HidInfo& info);
  /// Takes over what a report says. @rt safe. Counts nothing.
  /// @param report  as HidPort::read() gives it.   @param layout  of its interface; empty unless `needs_layout`.
  /// @param reading  what the report does not say stays.
  ReportKind (&take)(std::span<const std::uint8_t> report, const HidLayout& layout, DeviceReading& reading) noexcept;
  /// What it has to be sent to be lit or dark; none: it has no light.
  std::vector<OutputReport> (&light)(const HidInfo& info, bool is_lit);
};

std::span<const DeviceDriver* const> deviceDrivers();
/// Null: nobody's.
const DeviceDriver* driverOf(const HidInfo& info);
/// By its id. Null: there is none.
const DeviceDriver* findDriver(std::string_view id);

/// Lets the driver take a report, counts it, keeps when it came. @rt safe.
/// @param layout  of the interface that sent it, for a driver that needs one.
ReportKind takeReport(const DeviceDriver& driver, std::span<const std::uint8_t> report, std::int64_t time_ns,
                      DeviceReading& reading, const HidLayout& layout = {}) noexcept;

/// After so long without a report, s, axes are at rest whatever the last one said.
inline constexpr double kSilence = 0.1;
/// The axes as they count now: zero before the first report and, of a driver that says so, after kSilence. @rt safe.
std::array<double, 6> axesAt(const DeviceDriver& driver, const DeviceReading& reading, std::int64_t now_ns) noexcept;

/// CLOCK_MONOTONIC, ns. @rt safe.
std::int64_t deviceClock() noexcept;

}  // namespace kerf
