#include "ui/app/hand/space_mouse_link.h"

#include <utility>

#include "sim/device/hid/device_watch.h"
#include "ui/app/base/language.h"

namespace kerf {

bool isSpaceMouse(std::uint16_t vendor, std::uint16_t product) {
  constexpr std::uint16_t kGenericDesktop = 0x01, kMultiAxis = 0x08;
  HidInfo info;
  info.vendor = vendor;
  info.product = product;
  info.usage_page = kGenericDesktop;
  info.usage = kMultiAxis;
  return driverOf(info) != nullptr;
}

struct SpaceMouseLink::State {
  explicit State(std::string wanted) : watch(std::move(wanted)) {}
  DeviceWatch watch;
  std::shared_ptr<HidDevice> device;
  std::string name, trouble;  // as last reported
};

SpaceMouseLink::SpaceMouseLink(std::string name) : state_(std::make_unique<State>(std::move(name))) {}
SpaceMouseLink::~SpaceMouseLink() = default;

std::optional<SpaceMouseState> SpaceMouseLink::read() {
  State& s = *state_;
  if (!s.device || !s.device->isConnected()) s.device = s.watch.device();
  if (!s.device || !s.device->isConnected()) return {};
  const std::array<double, 6> axes = s.device->axes();
  return SpaceMouseState{axes, s.device->reading().buttons};
}

std::string SpaceMouseLink::name() const {
  const State& s = *state_;
  return s.device && s.device->isConnected() ? s.device->what().name : "";
}

std::optional<Battery> SpaceMouseLink::battery() const {
  const State& s = *state_;
  if (!s.device || !s.device->isConnected()) return {};
  return batteryOf(s.device->reading());
}

std::string SpaceMouseLink::trouble() const { return state_->watch.trouble(); }

std::optional<std::string> SpaceMouseLink::news() {
  State& s = *state_;
  const bool is_there = s.device && s.device->isConnected();
  const std::string name = is_there ? s.device->what().name : "", trouble = is_there ? "" : s.watch.trouble();
  const std::string last_name = std::exchange(s.name, name), last_trouble = std::exchange(s.trouble, trouble);
  if (name != last_name) return name.empty() ? phrase("{} was unplugged", last_name) : phrase("{} is ready", name);
  if (trouble != last_trouble && !trouble.empty()) return trouble;
  return {};
}

}  // namespace kerf
