#include "ui/app/gamepad_link.h"

#include <fmt/format.h>

#include "sim/device/device_watch.h"

namespace kerf {

struct GamepadLink::State {
  std::optional<PadId> pad;
  std::unique_ptr<DeviceWatch> watch;
  std::shared_ptr<HidDevice> device;
};

GamepadLink::GamepadLink() : state_(std::make_unique<State>()) {}
GamepadLink::~GamepadLink() = default;

GamepadDetails GamepadLink::update(const std::optional<PadId>& pad) {
  State& s = *state_;
  if (pad != s.pad) {
    s.device.reset();
    s.watch.reset();
    s.pad = pad;
    if (pad)
      s.watch = std::make_unique<DeviceWatch>("", 1000, [id = *pad](const FoundDevice& found) {
        const HidInfo& info = found.interfaces.front();
        return info.vendor == id.vendor && info.product == id.product;
      });
  }
  if (!s.watch) return {};

  s.device = s.watch->device();
  GamepadDetails out;
  if (!s.device || !s.device->isConnected()) {
    const std::string trouble = s.watch->trouble();
    out.shake =
        trouble.empty()
            ? "it is no HID device here, so it is not known how it shakes: an Xbox pad is one by Bluetooth alone"
            : trouble;
    return out;
  }
  s.device->update();
  out.battery = batteryOf(s.device->reading());
  const auto kind = padKindOf(s.device->what().interfaces.front());
  out.can_shake = kind.has_value();
  out.shake = kind
                  ? std::string(nameOf(*kind)) + ": shakes while it drills"
                  : fmt::format("{:04x}:{:04x} is not known to shake: DualSense, DualShock 4 and Xbox by Bluetooth are",
                                pad->vendor, pad->product);
  return out;
}

}  // namespace kerf
