// Holds a tool in an attitude: the hand turns against the torque, like a cutting guide.
#pragma once

#include "sim/step/device_sample.h"

namespace kerf {

/// The coupling gives way by torque / stiffness; the hand slowly turns back by this. @rt
struct ToolLean {
  static constexpr double kRate = 8;    ///< 1/s
  static constexpr double kMost = 0.2;  ///< rad

  Vec3d turn = Vec3d::Zero();  ///< rotation vector, world, rad

  /// @param torque  on the hand, N mm.   @param stiffness  of the coupling, N mm/rad.
  void against(const Vec3d& torque, double stiffness) noexcept {
    turn -= kRate * kTick * (turn + torque / stiffness);
    if (const double size = turn.norm(); size > kMost) turn *= kMost / size;
  }
  Eigen::Quaterniond of(const Eigen::Quaterniond& attitude) const noexcept {
    const double angle = turn.norm();
    if (!(angle > 0)) return attitude;
    return (Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3d(turn / angle))) * attitude).normalized();
  }
};

}  // namespace kerf
