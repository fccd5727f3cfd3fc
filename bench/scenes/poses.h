// Attitudes and samples shared by scenes. Object frame, mm.
#pragma once

#include "geometry/base/types.h"
#include "sim/step/device_sample.h"

namespace kerf::scenes {

/// A rotation by `angle` (rad) about `axis`, of any length, then a shift.
Rigid3 turned(double angle, const Vec3d& axis, const Vec3d& shift = Vec3d::Zero());

/// Turns every scene axis away from the grid axes.
Rigid3 askew();

/// A blade across the x axis, its teeth towards -z: tool z along x, tool x up.
Eigen::Quaterniond teethDown();
/// The same blade on its side, a flank towards -z.
Eigen::Quaterniond flankDown();

/// A valid device sample at `pose`.   @param pedal  0 to 1.
DeviceSample sampleAt(const Rigid3& pose, double pedal = 1);

}  // namespace kerf::scenes
