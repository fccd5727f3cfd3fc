#include "sim/device/pad_kind.h"

namespace kerf {
namespace {

struct Model {
  std::uint16_t vendor, product;
  bool is_bluetooth;
  PadKind kind;
};
constexpr Model kModels[] = {
    {0x054c, 0x0ce6, false, PadKind::kDualSense},    {0x054c, 0x0ce6, true, PadKind::kDualSenseBluetooth},
    {0x054c, 0x0df2, false, PadKind::kDualSense},    {0x054c, 0x0df2, true, PadKind::kDualSenseBluetooth},
    {0x054c, 0x05c4, false, PadKind::kDualShock4},   {0x054c, 0x05c4, true, PadKind::kDualShock4Bluetooth},
    {0x054c, 0x09cc, false, PadKind::kDualShock4},   {0x054c, 0x09cc, true, PadKind::kDualShock4Bluetooth},
    {0x045e, 0x02e0, true, PadKind::kXboxBluetooth}, {0x045e, 0x02fd, true, PadKind::kXboxBluetooth},
    {0x045e, 0x0b05, true, PadKind::kXboxBluetooth}, {0x045e, 0x0b13, true, PadKind::kXboxBluetooth},
    {0x045e, 0x0b20, true, PadKind::kXboxBluetooth},
};

}  // namespace

std::optional<PadKind> padKindOf(const HidInfo& info) {
  for (const Model& m : kModels)
    if (m.vendor == info.vendor && m.product == info.product && m.is_bluetooth == info.is_bluetooth) return m.kind;
  return {};
}

const char* nameOf(PadKind kind) {
  switch (kind) {
    case PadKind::kDualSense:
      return "DualSense";
    case PadKind::kDualSenseBluetooth:
      return "DualSense by Bluetooth";
    case PadKind::kDualShock4:
      return "DualShock 4";
    case PadKind::kDualShock4Bluetooth:
      return "DualShock 4 by Bluetooth";
    case PadKind::kXboxBluetooth:
      break;
  }
  return "Xbox by Bluetooth";
}

}  // namespace kerf
