// DualSense and DualShock 4: what their reports say beyond what their descriptor explains, the battery above all, and
// by Bluetooth everything. Never tried on hardware: layouts are those that Linux's hid-playstation and SDL read.
//
//                       report     sticks    triggers  buttons   battery        bytes, the report's number first
//   DualSense    USB    1, 64      1 to 4    5, 6      8 to 10   53
//                Bt     0x31, 78   2 to 5    6, 7      9 to 11   54
//   DualShock 4  USB    1, 64      1 to 4    8, 9      5 to 7    30
//                Bt     0x11, 78   3 to 6    10, 11    7 to 9    32
//   both, Bt, until they are told something: 1, 10 as DualShock 4 on a cable, without battery
//
// Axes as a descriptor names them on a cable: X, Y the left stick, Z, Rz the right one, Rx, Ry the triggers. Buttons 61
// to 64 are the cross: up, right, down, left.
#include <algorithm>

#include "sim/device/device_driver.h"
#include "sim/device/pad_kind.h"

namespace kerf {
namespace {

using Report = std::span<const std::uint8_t>;

const char* nameIfOneOf(const HidInfo& info, PadKind usb, PadKind bluetooth) {
  const auto kind = padKindOf(info);
  return kind && (*kind == usb || *kind == bluetooth) ? nameOf(*kind) : nullptr;
}
const char* dualSenseName(const HidInfo& info) {
  return nameIfOneOf(info, PadKind::kDualSense, PadKind::kDualSenseBluetooth);
}
const char* dualShockName(const HidInfo& info) {
  return nameIfOneOf(info, PadKind::kDualShock4, PadKind::kDualShock4Bluetooth);
}

// Where a report has what.
struct Places {
  std::size_t sticks, triggers, buttons;
};
constexpr Places kShort = {1, 8, 5};

double axis(std::uint8_t value) { return std::clamp((value - 127.5) / 127.5, -1.0, 1.0); }

void takeSticks(Report report, const Places& at, DeviceReading& reading) {
  reading.axes = {axis(report[at.sticks]),   axis(report[at.sticks + 1]),   axis(report[at.sticks + 2]),
                  axis(report[at.triggers]), axis(report[at.triggers + 1]), axis(report[at.sticks + 3])};
}

// Four bits of the cross, eighths clockwise from up, 8 at rest; then 14 buttons.
void takeButtons(Report report, const Places& at, DeviceReading& reading) {
  constexpr std::uint64_t kUp = 1, kRight = 2, kDown = 4, kLeft = 8;
  constexpr std::uint64_t kCross[] = {kUp,   kUp | kRight,  kRight, kRight | kDown,
                                      kDown, kDown | kLeft, kLeft,  kLeft | kUp};
  constexpr int kFirstOfCross = 60;
  const std::size_t cross = report[at.buttons] & 15U;
  const std::uint64_t others =
      (report[at.buttons] >> 4) | (report[at.buttons + 1] << 4) | ((report[at.buttons + 2] & 3U) << 12);
  reading.buttons = others | (cross < 8 ? kCross[cross] << kFirstOfCross : 0);
}

// Tenths, as its lower bits count them.
int percentOf(unsigned tenths) { return tenths < 10 ? static_cast<int>(10 * tenths + 5) : 100; }

void takeDualSenseBattery(std::uint8_t said, DeviceReading& reading) {
  constexpr unsigned kDrawn = 0, kCharging = 1, kFull = 2;
  const unsigned state = said >> 4;
  reading.is_charging = state == kCharging;
  if (state == kDrawn || state == kCharging)
    reading.battery_percent = percentOf(said & 15U);
  else
    reading.battery_percent = state == kFull ? 100 : -1;  // else too hot, or broken
}

void takeDualShockBattery(std::uint8_t said, DeviceReading& reading) {
  constexpr unsigned kOnCable = 0x10, kMost = 10;
  const unsigned tenths = said & 15U;
  reading.is_charging = (said & kOnCable) && tenths <= kMost;
  reading.battery_percent = percentOf(tenths);
}

ReportKind takeDualSense(Report report, const HidLayout&, DeviceReading& reading) noexcept {
  if (report.empty()) return ReportKind::kMalformed;
  const bool is_usb = report[0] == 1, is_bluetooth = report[0] == 0x31;
  if (!is_usb && !is_bluetooth) return ReportKind::kUnknown;
  const bool is_short = is_usb && report.size() == 10;
  if (!is_short && report.size() != (is_usb ? 64U : 78U)) return ReportKind::kMalformed;

  const std::size_t first = is_usb ? 1 : 2;
  const Places at = is_short ? kShort : Places{first, first + 4, first + 7};
  takeSticks(report, at, reading);
  takeButtons(report, at, reading);
  if (!is_short) takeDualSenseBattery(report[first + 52], reading);
  return ReportKind::kMotion;
}

ReportKind takeDualShock(Report report, const HidLayout&, DeviceReading& reading) noexcept {
  if (report.empty()) return ReportKind::kMalformed;
  const bool is_usb = report[0] == 1, is_bluetooth = report[0] == 0x11;
  if (!is_usb && !is_bluetooth) return ReportKind::kUnknown;
  const bool is_short = is_usb && report.size() == 10;
  if (!is_short && report.size() != (is_usb ? 64U : 78U)) return ReportKind::kMalformed;

  const std::size_t first = is_usb ? 1 : 3;
  const Places at = {first, first + 7, first + 4};
  takeSticks(report, at, reading);
  takeButtons(report, at, reading);
  if (!is_short) takeDualShockBattery(report[first + 29], reading);
  return ReportKind::kMotion;
}

// Its light is left as it is: a report that sets it by Bluetooth changes what the pad sends from then on.
std::vector<OutputReport> light(const HidInfo&, bool) { return {}; }

constexpr AxisNames kAxes = {"X", "Y", "Z", "Rx", "Ry", "Rz"};

}  // namespace

// They say where they are all the time, many times a second: one that has fallen silent is out of reach.
extern const DeviceDriver kDualSense, kDualShock4;
const DeviceDriver kDualSense{
    "dualsense", "sticks, triggers, buttons, battery", kAxes, false, true, dualSenseName, takeDualSense, light};
const DeviceDriver kDualShock4{
    "dualshock4", "sticks, triggers, buttons, battery", kAxes, false, true, dualShockName, takeDualShock, light};

}  // namespace kerf
