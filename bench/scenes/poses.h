// Attitudes and samples that many scenes use. Object frame, mm.
#pragma once

#include "geometry/base/types.h"
#include "sim/step/device_sample.h"

namespace kerf::scenes {

/// A rotation by `angle` (rad) about `axis`, which need not be a unit vector, then a shift.
Rigid3 turned(double angle, const Vec3d& axis, const Vec3d& shift = Vec3d::Zero());

/// No axis of the grid is one of the scene's.
Rigid3 askew();

/// A blade across the x axis, its teeth towards -z: tool z along x, tool x up.
Eigen::Quaterniond teethDown();
/// The same blade on its side, a flank towards -z.
Eigen::Quaterniond flankDown();

/// A device that is valid and stands at `pose`.   @param pedal  0 to 1.
DeviceSample sampleAt(const Rigid3& pose, double pedal = 1);

}  // namespace kerf::scenes
