#include "sim/device/record/arm_opener.h"

#include <algorithm>
#include <iterator>

#include "sim/device/arm/bridge_device.h"
#include "sim/device/arm/hid_arm.h"
#include "sim/device/record/replay_arm.h"

namespace kerf {
namespace {

Expected<OpenedArm> openBridge(const std::string& address, const ArmSettings& settings, const Rigid3& start,
                               ArmListener listener) {
  KERF_TRY(port, parseBridgeAddress(address));
  KERF_TRY(arm, BridgeDevice::open({port, settings.limits, settings.map, start, settings.pedal_is_down},
                                   std::move(listener)));
  return OpenedArm{std::move(arm), "bridge"};
}

}  // namespace

DeviceProfile withTurning(DeviceProfile profile, const HandFrame& hand) {
  if (!hand.gives_torque || profile.inertia_kgmm2 > 0) return profile;
  profile.inertia_kgmm2 = 30;
  profile.turn_friction = 0.5;
  profile.encoder_rad = 0.002;
  return profile;
}

bool namesTransport(const std::string& name) {
  if (name == "bridge") return true;
  constexpr const char* kBegins[] = {"udp:", "bridge:", "replay:"};
  return std::any_of(std::begin(kBegins), std::end(kBegins), [&](const char* b) { return name.starts_with(b); });
}

Expected<OpenedArm> openArm(const std::string& name, const ArmSettings& settings, const Rigid3& start,
                            ArmListener listener) {
  if (name == "bridge") return openBridge("udp:" + std::to_string(kBridgePort), settings, start, std::move(listener));
  if (name.starts_with("udp:")) return openBridge(name, settings, start, std::move(listener));
  if (name.starts_with("bridge:")) return openBridge("udp:" + name.substr(7), settings, start, std::move(listener));
  if (name.starts_with("replay:")) {
    KERF_TRY(arm, ReplayArm::open(name.substr(7), settings, start));
    const std::string language = arm->language();
    return OpenedArm{std::move(arm), language};
  }
  if (name.empty())
    return fail(
        {.code = Error::Code::kBadValue,
         .place = "force-feedback device",
         .found = "no name",
         .expected = kArmNames,
         .hint = "list the connected devices with kerf devices; for all others see docs/reference/device-bridge.md"});
  std::vector<FoundDevice> arms = findDevices();
  std::erase_if(arms, [](const FoundDevice& found) { return !found.isArm(); });
  KERF_TRY(found, chooseDevice(arms, name));
  KERF_TRY(arm, HidArm::open(found, settings, start, std::move(listener)));
  return OpenedArm{std::move(arm), found.driver->id};
}

}  // namespace kerf
