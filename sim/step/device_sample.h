// Input from the hand and output to it, once per tick: the whole interface between a device and the simulation.
#pragma once

#include <cstdint>
#include <type_traits>

#include "geometry/base/types.h"

namespace kerf {

/// Length of a tick, s. Fixed: the laws hold for any value, a session's record only for this one.
inline constexpr double kTick = 1e-3;

/// Force and torque about a named point, in a named frame.
struct Wrench {
  Vec3d force = Vec3d::Zero();   ///< N
  Vec3d torque = Vec3d::Zero();  ///< N mm
};

/// One sample of the device, as stored in the session log. The state depends only on samples, commands and the case.
struct DeviceSample {
  Rigid3 T_world_device;  ///< pose at which the hand holds the tool: tip and axes, mm
  double pedal = 0;       ///< 0 to 1 of the tool's nominal speed; negative: backwards, if the motor can
  double irrigation = 1;  ///< 0 to 1 of the cooling spray
  /// 0: no sample arrived in time, or it was not finite. Force goes to zero and stays there.
  std::uint32_t is_valid = 1;

  /// A valid sample whose pose is usable (Rigid3::isUsable), pedal and irrigation in range.
  bool isUsable() const;
};

/// Output to the hand: force and torque about the tool's tip, world axes.
using DeviceForce = Wrench;

}  // namespace kerf
