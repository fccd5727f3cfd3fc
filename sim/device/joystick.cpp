// Joysticks and gamepads whose reports their own HID descriptor explains (HID 1.11, usage tables 1.12): axes of the
// page of generic desktop controls, accelerator and brake of the page of simulation controls for the triggers of some
// pads, buttons, the hat, a battery. Never tried on hardware. Pads of Sony say more, in
// bytes that their descriptor does not explain: sony_pads.cpp.
//
// Numbered as HID does it: X right, Y to the person, Z, then Rx, Ry, Rz. Buttons 61 to 64 are the hat: up, right, down,
// left.
#include <algorithm>

#include "sim/device/device_driver.h"
#include "sim/device/pad_kind.h"

namespace kerf {
namespace {

constexpr HidUsage onPage(std::uint32_t page, std::uint32_t usage) { return (page << 16) | usage; }
constexpr std::uint32_t kDesktop = 1, kSimulation = 2, kButtonPage = 9;
constexpr HidUsage kX = onPage(kDesktop, 0x30), kRz = onPage(kDesktop, 0x35), kHat = onPage(kDesktop, 0x39);
constexpr HidUsage kAccelerator = onPage(kSimulation, 0xC4), kBrake = onPage(kSimulation, 0xC5);
constexpr HidUsage kBattery = onPage(6, 0x20);
constexpr std::uint32_t kMostButtons = 60;  // beyond are those of the hat

const char* nameOf(const HidInfo& info) {
  constexpr std::uint16_t kJoystickUsage = 4, kGamepadUsage = 5;
  if (info.usage_page != kDesktop) return nullptr;
  if (info.usage != kJoystickUsage && info.usage != kGamepadUsage) return nullptr;
  if (const auto kind = padKindOf(info)) return nameOf(*kind);
  return info.usage == kGamepadUsage ? "gamepad" : "joystick";
}

// Which of six axes a usage is; 6: none.
std::size_t axisOf(HidUsage usage) {
  constexpr std::size_t kRx = 3, kRy = 4, kNone = 6;
  if (usage >= kX && usage <= kRz) return usage - kX;
  if (usage == kBrake) return kRx;
  return usage == kAccelerator ? kRy : kNone;
}

// 0 to 1 of what the field can say.
double shareOf(const HidField& field, std::int64_t value) {
  const double low = field.logical_min, high = field.logical_max;
  return std::clamp((static_cast<double>(value) - low) / (high - low), 0.0, 1.0);
}

std::uint64_t hatButtons(const HidField& field, std::int64_t value) {
  constexpr std::int64_t kDirections = 8;
  const std::int64_t turn = value - field.logical_min;  // eighths clockwise from up; anything else: at rest
  if (field.logical_max - field.logical_min != kDirections - 1 || turn < 0 || turn >= kDirections) return 0;
  constexpr std::uint64_t kUp = 1, kRight = 2, kDown = 4, kLeft = 8;
  constexpr std::uint64_t kOf[] = {kUp, kUp | kRight, kRight, kRight | kDown, kDown, kDown | kLeft, kLeft, kLeft | kUp};
  return kOf[turn] << kMostButtons;
}

// What one value means for a reading.
struct Taker {
  DeviceReading& reading;
  std::uint64_t buttons = 0;
  bool has_axes = false, has_buttons = false, has_battery = false;

  void take(const HidField& field, HidUsage usage, std::int64_t value) {
    if (usage >> 16 == kButtonPage) {
      const std::uint32_t number = usage & 0xFFFF;
      has_buttons = true;
      if (number >= 1 && number <= kMostButtons && value != 0) buttons |= std::uint64_t{1} << (number - 1);
    } else if (usage == kHat) {
      has_buttons = true;
      buttons |= hatButtons(field, value);
    } else if (field.logical_max <= field.logical_min) {
      return;
    } else if (const std::size_t axis = axisOf(usage); axis < reading.axes.size()) {
      has_axes = true;
      reading.axes[axis] = 2 * shareOf(field, value) - 1;
    } else if (usage == kBattery) {
      has_battery = true;
      reading.battery_percent = static_cast<int>(100 * shareOf(field, value) + 0.5);
    }
  }
};

ReportKind take(std::span<const std::uint8_t> report, const HidLayout& layout, DeviceReading& reading) noexcept {
  if (report.empty()) return ReportKind::kMalformed;
  const std::uint8_t number = layout.has_numbers ? report[0] : std::uint8_t{0};
  const std::size_t size = layout.bytesOf(HidReportKind::kInput, number);
  if (size == 0) return ReportKind::kUnknown;
  if (report.size() < size) return ReportKind::kMalformed;

  Taker taker{reading};
  for (const HidField& field : layout.fields) {
    const bool is_meant = field.kind == HidReportKind::kInput && field.report == number;
    if (!is_meant || field.is_constant || field.is_array || field.usages.empty()) continue;
    for (std::uint32_t n = 0; n < field.count; ++n) {
      const HidUsage usage = field.usages[std::min<std::size_t>(n, field.usages.size() - 1)];
      taker.take(field, usage, getHidValue(report, layout.has_numbers, field, n));
    }
  }
  if (taker.has_buttons) reading.buttons = taker.buttons;
  if (taker.has_axes) return ReportKind::kMotion;
  if (taker.has_buttons) return ReportKind::kButtons;
  return taker.has_battery ? ReportKind::kBattery : ReportKind::kUnknown;
}

// Lights are left as they are.
std::vector<OutputReport> light(const HidInfo&, bool) { return {}; }

constexpr AxisNames kAxes = {"X", "Y", "Z", "Rx", "Ry", "Rz"};

}  // namespace

extern const DeviceDriver kJoystick;
const DeviceDriver kJoystick{"joystick", "axes and buttons by its descriptor",
                             kAxes,      true,
                             false,  // many say nothing while nothing moves
                             nameOf,     take,
                             light};

}  // namespace kerf
