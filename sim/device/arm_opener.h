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
  DeviceProfile profile;  ///< of its kind, of the device alone; of an unknown one where its kind tells nothing
};

inline constexpr std::uint16_t kBridgePort = 4417;

/// @param name  "bridge" (port kBridgePort), "bridge:PORT", "udp:PORT"; "haply", "haply:PORT" of this machine;
/// "serial:PATH"; else path or serial number of an arm on HID.
/// @param start  of the tool, world: there the hand finds it.
/// Errors: kBadValue: a name that is none; those of opening.
Expected<OpenedArm> openArm(const std::string& name, const ArmSettings& settings, const Rigid3& start = {});

/// The profile of a device as it says it is: of one that gives torque, and of whose turning nothing is known, light in
/// turning, so that its coupling is soft.
DeviceProfile withTurning(DeviceProfile profile, const HandFrame& hand);

/// What a name may be, for help texts.
inline constexpr const char* kArmNames =
    "bridge, bridge:PORT, haply, serial:/dev/ttyACM0, or path or serial number of an arm that kerf devices lists";

}  // namespace kerf
