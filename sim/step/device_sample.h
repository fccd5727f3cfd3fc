// What a hand asks for and what it gets back, once per tick: the whole interface between a device and the simulation.
#pragma once

#include <cstdint>
#include <type_traits>

#include "geometry/base/types.h"

namespace kerf {

/// Length of a tick, s. Fixed: the laws are valid for any, the record of a session only for this one.
inline constexpr double kTick = 1e-3;

/// Force and torque about a named point, in a named frame.
struct Wrench {
  Vec3d force = Vec3d::Zero();   ///< N
  Vec3d torque = Vec3d::Zero();  ///< N mm
};

/// One sample of the device, as the session log keeps it. A state is a function of these, the commands and the case.
struct DeviceSample {
  Rigid3 T_world_device;  ///< where the hand holds the tool: tip and axes, mm
  double pedal = 0;       ///< 0 to 1 of the tool's nominal speed; negative: backwards, by a motor that can
  double irrigation = 1;  ///< 0 to 1 of the cooling spray
  /// 0: no sample arrived in time, or it was not finite. Force goes to zero and stays there.
  std::uint32_t is_valid = 1;

  /// A valid sample whose pose is usable (Rigid3::isUsable), pedal and irrigation in range.
  bool isUsable() const;
};

/// What goes back to the hand: force and torque about the tool's tip, world axes.
using DeviceForce = Wrench;

}  // namespace kerf
