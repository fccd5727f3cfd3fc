// A tool fed along a straight line through an object, and its forces: slots, saw cuts.
#pragma once

#include "sim/step/step.h"

namespace kerf::scenes {

/// Means over the steady part of a straight feed, and the largest changes per tick.
struct Feed {
  double force = 0;                ///< N, of contact
  double normal = 0;               ///< N, the load normal to the tissue
  double rate = 0;                 ///< mm^3/s removed
  double thrust = 0;               ///< N, against the feed
  double drag = 0;                 ///< N, load of the drive
  double jump = 0;                 ///< N a tick, the largest change of force
  double turn_jump = 0;            ///< N mm a tick, the largest change of torque
  std::uint32_t status = kStepOk;  ///< every bit of StepStatus set by a tick
};

/// Feeds the first tool along `way`, the pedal down.
/// @param state  the tool cuts its first object.   @param frame  of the object.
/// @param from  first pose, in that frame.   @param speed  mm/s.
/// @param steady_from  share of the way before the means start, [0, 1).
Feed feed(const Model& model, State& state, const Rigid3& frame, const Rigid3& from, const Vec3d& way, double speed,
          double steady_from);

/// A ball of 1.6 mm draws a slot, 0.6 mm deep, at 2 mm/s, through a block of one tissue: friction 0.5, surface 840
/// mm/s. Removal is mu N v / u_s (Preston).
/// @param voxel  mm.   @param frame  of the block.   @param energy  specific cutting energy u_s, N/mm^2.
Expected<Feed> slot(double voxel, const Rigid3& frame, double energy = 1000);

}  // namespace kerf::scenes
