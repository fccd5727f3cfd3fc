// The SpaceMouse family of 3Dconnexion: a knob to push and turn along six axes, and buttons. Untested on hardware: ids
// and reports are those published by others.
//
//   report  bytes with its number  what
//   1       7                      X Y Z, int16 each                  older ones: pushing and turning by turns
//   2       7                      turning about X Y Z
//   1       13                     X Y Z, turning about X Y Z         newer ones
//   3       2 to 9                 buttons, a bit each, lowest first
//   0x1C    3 and more             numbers of the buttons that are down, uint16 each; 0: none
//   0x1D    3 and more             the same, of those that are held long
//   0x17    3                      battery, %; bit 0 of the next byte: it is charging
//   4       2, to the device       light
//
// Each report shows its format; the id does not, since the same id was sold with either. X is to the right, Y to the
// person, Z down; full deflection is about 350.
#include <algorithm>
#include <array>
#include <string_view>

#include "sim/device/hid/device_driver.h"

namespace kerf {
namespace {

constexpr double kFull = 350;

struct Model {
  std::uint16_t vendor, product;
  const char* name;
};
constexpr Model kModels[] = {
    {0x046d, 0xc603, "SpaceMouse Plus XT"},
    {0x046d, 0xc605, "CADman"},
    {0x046d, 0xc606, "SpaceMouse Classic"},
    {0x046d, 0xc621, "Spaceball 5000"},
    {0x046d, 0xc623, "SpaceTraveler"},
    {0x046d, 0xc625, "SpacePilot"},
    {0x046d, 0xc626, "SpaceNavigator"},
    {0x046d, 0xc627, "SpaceExplorer"},
    {0x046d, 0xc628, "SpaceNavigator for Notebooks"},
    {0x046d, 0xc629, "SpacePilot Pro"},
    {0x046d, 0xc62b, "SpaceMouse Pro"},
    {0x256f, 0xc62e, "SpaceMouse Wireless, cable"},
    {0x256f, 0xc62f, "SpaceMouse Wireless, receiver"},
    {0x256f, 0xc631, "SpaceMouse Pro Wireless, cable"},
    {0x256f, 0xc632, "SpaceMouse Pro Wireless, receiver"},
    {0x256f, 0xc633, "SpaceMouse Enterprise"},
    {0x256f, 0xc635, "SpaceMouse Compact"},
    {0x256f, 0xc636, "SpaceMouse Module"},
    {0x256f, 0xc638, "SpaceMouse Pro Wireless BT, cable"},
    {0x256f, 0xc63a, "SpaceMouse Wireless BT"},
    {0x256f, 0xc652, "Universal Receiver"},
    {0x256f, 0xc658, "Universal Receiver"},
};
constexpr std::uint16_t kCompact = 0xc635;

// A multi-axis controller: the same devices have interfaces of keyboards and mice.
const char* nameOfSpaceMouse(const HidInfo& info) {
  constexpr std::uint16_t kGenericDesktop = 0x01, kMultiAxis = 0x08;
  if (info.usage_page != kGenericDesktop || info.usage != kMultiAxis) return nullptr;
  const auto* const found = std::find_if(std::begin(kModels), std::end(kModels), [&](const Model& m) {
    return m.vendor == info.vendor && m.product == info.product;
  });
  return found == std::end(kModels) ? nullptr : found->name;
}

int word(std::span<const std::uint8_t> report, std::size_t at) noexcept {
  return static_cast<std::int16_t>(report[at] | (report[at + 1] << 8));
}

// Three axes, from the frame of the device (right, to the person, down) to that of a reading.
void takeThree(std::span<const std::uint8_t> report, std::size_t at, double* axes) noexcept {
  constexpr double kSign[] = {1, -1, -1};
  for (std::size_t n = 0; n < 3; ++n)
    axes[n] = kSign[n] * std::clamp(word(report, at + 2 * n) / kFull, -1.0, 1.0) + 0.0;  // no -0
}

ReportKind takeMotion(std::span<const std::uint8_t> report, DeviceReading& reading) noexcept {
  const bool turns = report[0] == 2;
  if (report.size() != 7 && (turns || report.size() != 13)) return ReportKind::kMalformed;
  takeThree(report, 1, reading.axes.data() + (turns ? 3 : 0));
  if (report.size() == 13) takeThree(report, 7, reading.axes.data() + 3);
  return ReportKind::kMotion;
}

ReportKind takeBits(std::span<const std::uint8_t> report, DeviceReading& reading) noexcept {
  if (report.size() < 2 || report.size() > 9) return ReportKind::kMalformed;
  reading.buttons = 0;
  for (std::size_t n = 1; n < report.size(); ++n) reading.buttons |= std::uint64_t{report[n]} << (8 * (n - 1));
  return ReportKind::kButtons;
}

ReportKind takeNumbers(std::span<const std::uint8_t> report, DeviceReading& reading) noexcept {
  if (report.size() < 3 || report.size() % 2 == 0) return ReportKind::kMalformed;
  std::uint64_t buttons = 0;
  bool are_known = true;
  for (std::size_t at = 1; at < report.size(); at += 2) {
    const int number = report[at] | (report[at + 1] << 8);
    if (number >= 1 && number <= 64) buttons |= std::uint64_t{1} << (number - 1);
    are_known = are_known && number <= 64;
  }
  reading.buttons = buttons;
  return are_known ? ReportKind::kButtons : ReportKind::kUnknown;
}

ReportKind takeBattery(std::span<const std::uint8_t> report, DeviceReading& reading) noexcept {
  if (report.size() != 3 || report[1] > 100) return ReportKind::kMalformed;
  reading.battery_percent = report[1];
  reading.is_charging = report[2] & 1;
  return ReportKind::kBattery;
}

ReportKind takeSpaceMouse(std::span<const std::uint8_t> report, DeviceReading& reading) noexcept {
  if (report.empty()) return ReportKind::kMalformed;
  switch (report[0]) {
    case 1:
    case 2:
      return takeMotion(report, reading);
    case 3:
      return takeBits(report, reading);
    case 0x1C:
    case 0x1D:
      return takeNumbers(report, reading);
    case 0x17:
      return takeBattery(report, reading);
    default:
      return ReportKind::kUnknown;
  }
}

std::vector<OutputReport> lightSpaceMouse(const HidInfo& info, bool is_lit) {
  const OutputReport on{4, 1}, off{4, 0};
  if (is_lit) return {on};
  // This device goes dark only if it was lit before.
  if (info.vendor == 0x256f && info.product == kCompact) return {on, off};
  return {off};
}

constexpr AxesDriver kSpaceMouseReports{takeSpaceMouse, lightSpaceMouse};

}  // namespace

extern const DeviceDriver kSpaceMouse;
const DeviceDriver kSpaceMouse{"spacemouse", "six axes and buttons, no force", nameOfSpaceMouse, &kSpaceMouseReports,
                               nullptr};

}  // namespace kerf
