#include "sim/device/hid/device_driver.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string_view>

namespace kerf {

// A driver is a row in its own source, and its name in these two lines.
extern const DeviceDriver kSpaceMouse, kRawArm;
namespace {
constexpr const DeviceDriver* kDrivers[] = {&kSpaceMouse, &kRawArm};
}  // namespace

std::span<const DeviceDriver* const> deviceDrivers() { return kDrivers; }

const DeviceDriver* driverOf(const HidInfo& info) {
  const auto* const found = std::find_if(std::begin(kDrivers), std::end(kDrivers),
                                         [&](const DeviceDriver* driver) { return driver->nameOf(info) != nullptr; });
  return found == std::end(kDrivers) ? nullptr : *found;
}

const DeviceDriver* findDriver(std::string_view id) {
  const auto* const found =
      std::find_if(std::begin(kDrivers), std::end(kDrivers), [&](const DeviceDriver* d) { return d->id == id; });
  return found == std::end(kDrivers) ? nullptr : *found;
}

TakeHand* findTakeHand(std::string_view language) {
  if (language == "bridge") return decode;
  const DeviceDriver* const driver = findDriver(language);
  return driver && driver->arm ? &driver->arm->take : nullptr;
}

ReportKind takeReport(const DeviceDriver& driver, std::span<const std::uint8_t> report, std::int64_t time_ns,
                      DeviceReading& reading) noexcept {
  const ReportKind kind = driver.axes->take(report, reading);
  switch (kind) {
    case ReportKind::kUnknown:
      ++reading.unknown;
      return kind;
    case ReportKind::kMalformed:
      ++reading.malformed;
      return kind;
    case ReportKind::kMotion:
    case ReportKind::kButtons:
    case ReportKind::kBattery:
      break;
  }
  ++reading.reports;
  // A battery report must not keep an old motion alive.
  if (kind == ReportKind::kMotion || reading.time_ns == 0) reading.time_ns = time_ns;
  return kind;
}

std::array<double, 6> axesAt(const DeviceReading& reading, std::int64_t now_ns) noexcept {
  const bool is_silent = static_cast<double>(now_ns - reading.time_ns) > 1e9 * kSilence;
  return reading.time_ns == 0 || is_silent ? std::array<double, 6>{} : reading.axes;
}

std::int64_t deviceClock() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace kerf
