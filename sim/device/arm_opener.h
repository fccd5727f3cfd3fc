// From a name to an open force-feedback arm.
#pragma once

#include <memory>
#include <string>

#include "geometry/base/error.h"
#include "sim/device/force_arm.h"
#include "sim/hand/device_profile.h"

namespace kerf {

struct OpenedArm {
  std::unique_ptr<ForceArm> arm;
  std::string language;  ///< of its messages: findTakeHand()
};

inline constexpr std::uint16_t kBridgePort = 4417;

/// A name of a bridge or a recording, not of a HID device. Such arms are not listed.
bool namesTransport(const std::string& name);

/// @param name  "bridge" (port kBridgePort), "bridge:PORT", "udp:PORT"; "replay:FILE", a recording; else path or serial
/// number of an arm on HID.
/// @param start  of the tool, world: there the hand finds it.
/// @param listener  of its messages; a recording has none.
/// Errors: kBadValue: a name that is none; those of opening.
Expected<OpenedArm> openArm(const std::string& name, const ArmSettings& settings, const Rigid3& start = {},
                            ArmListener listener = {});

/// The profile of a device as it says it is: of one that gives torque, and of whose turning nothing is known, light in
/// turning, so that its coupling is soft.
DeviceProfile withTurning(DeviceProfile profile, const HandFrame& hand);

/// What a name may be, for help texts.
inline constexpr const char* kArmNames =
    "bridge, bridge:PORT, replay:FILE, or path or serial number of an arm that kerf devices lists";

}  // namespace kerf
