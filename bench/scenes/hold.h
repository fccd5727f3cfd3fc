// A guided hand pushes a tool along a line with constant force: removal, feed, and drive.
#pragma once

#include <limits>

#include "sim/step/step.h"

namespace kerf::scenes {

struct HoldScene {
  std::shared_ptr<const BakedObject> object;
  Rigid3 start;                 ///< of the tool, in the frame of the object
  Vec3d way = -Vec3d::UnitZ();  ///< unit: direction of the push
  double force = 1;             ///< N
  double seconds = 2;           ///< maximum duration
  double settle = 0.5;          ///< s before means are taken
  double pedal = 1;             ///< -1 to 1, as DeviceSample::pedal
  double pedal_up_at = 1e9;     ///< s: pedal release
};

struct Hold {
  double rate = 0;              ///< mm^3/s, mean after settling
  double feed = 0;              ///< mm/s along the way, mean after settling
  double speed = 0;             ///< of the drive over its free speed, mean after settling
  double last_speed = 0;        ///< of the drive over its free speed, at the end
  double power = 0;             ///< N mm/s, mean after settling
  Vec3d aside = Vec3d::Zero();  ///< force on the tool across the push, N, mean after settling
  double torque = 0;            ///< load of the drive, mean after settling
  double depth = 0;             ///< mm along the push at the end
  double seconds = 0;           ///< duration
  /// s: first time with the drive below 1 % of its speed after the pedal is up; NaN, which meets no goal: never
  double stopped_at = std::numeric_limits<double>::quiet_NaN();
};

/// Reserves bricks between ticks, so a lack of bricks never limits the cut.
Hold hold(const Model& model, const HoldScene& scene);

}  // namespace kerf::scenes
