// A tool that a guided hand pushes along a line with constant force: what it takes off, how fast, what its drive does.
#pragma once

#include <limits>

#include "sim/step/step.h"

namespace kerf::scenes {

struct HoldScene {
  std::shared_ptr<const BakedObject> object;
  Rigid3 start;                 ///< of the tool, in the frame of the object
  Vec3d way = -Vec3d::UnitZ();  ///< unit: where the hand pushes
  double force = 1;             ///< N
  double seconds = 2;           ///< at most
  double settle = 0.5;          ///< s before means are taken
  double pedal = 1;             ///< -1 to 1, as DeviceSample::pedal
  double pedal_up_at = 1e9;     ///< s: the pedal is up from then on
};

struct Hold {
  double rate = 0;              ///< mm^3/s, mean after settling
  double feed = 0;              ///< mm/s along the way, mean after settling
  double speed = 0;             ///< of the drive over its free speed, mean after settling
  double last_speed = 0;        ///< of the drive over its free speed, at the end
  double power = 0;             ///< N mm/s, mean after settling
  Vec3d aside = Vec3d::Zero();  ///< force on the tool across the way, N, mean after settling
  double torque = 0;            ///< load of the drive, mean after settling
  double depth = 0;             ///< mm along the way at the end
  double seconds = 0;           ///< until the end
  /// s: the drive's speed first below 1 % after the pedal was up; NaN, which meets no goal: never
  double stopped_at = std::numeric_limits<double>::quiet_NaN();
};

/// Reserves bricks between ticks: nothing is left uncut for want of room.
Hold hold(const Model& model, const HoldScene& scene);

}  // namespace kerf::scenes
