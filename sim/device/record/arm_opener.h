// Opens a force-feedback arm by name.
#pragma once

#include <memory>
#include <string>

#include "geometry/base/error.h"
#include "sim/device/arm/force_arm.h"
#include "sim/hand/device_profile.h"

namespace kerf {

struct OpenedArm {
  std::unique_ptr<ForceArm> arm;
  std::string language;  ///< of its messages: findTakeHand()
};

inline constexpr std::uint16_t kBridgePort = 4417;

/// True for names of a bridge or a recording, not of a HID device. Such arms are not listed.
bool namesTransport(const std::string& name);

/// @param name  "bridge" (port kBridgePort), "bridge:PORT", "udp:PORT"; "replay:FILE", a recording; else path or serial
/// number of an arm on HID.
/// @param start  pose of the tool, world, where the hand begins.
/// @param listener  gets the arm's messages; a recording has none.
/// Errors: kBadValue: no valid name; those of opening.
Expected<OpenedArm> openArm(const std::string& name, const ArmSettings& settings, const Rigid3& start = {},
                            ArmListener listener = {});

/// The profile, completed by the device's report. A device that gives torque, with unknown inertia, counts as light in
/// turning, so that its coupling is soft.
DeviceProfile withTurning(DeviceProfile profile, const HandFrame& hand);

/// Valid names, for help texts.
inline constexpr const char* kArmNames =
    "bridge, bridge:PORT, replay:FILE, or path or serial number of an arm that kerf devices lists";

}  // namespace kerf
