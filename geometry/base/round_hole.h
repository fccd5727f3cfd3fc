// A straight round hole with a flat end.
#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/base/types.h"

namespace kerf {

/// mm. The mouth is the middle of the end where the drill enters; the axis points into the material.
struct RoundHole {
  static constexpr double kLeastDiameter = 0.3, kMostDiameter = 20, kMostDepth = 200;

  Vec3d mouth = Vec3d::Zero();
  Vec3d axis = Vec3d::UnitZ();  ///< unit
  double diameter = 0, depth = 0;

  /// Distance from the hole: negative in it. @rt
  double outside(const Vec3d& p) const noexcept {
    const double along = axis.dot(p - mouth);
    const double beside = (p - mouth - along * axis).norm() - 0.5 * diameter;
    const double beyond = std::max(-along, along - depth);
    if (beside > 0 && beyond > 0) return std::hypot(beside, beyond);
    return std::max(beside, beyond);
  }
  /// Unit, from the nearest point of the hole's wall outwards. @rt
  Vec3d outwards(const Vec3d& p) const noexcept {
    const double along = axis.dot(p - mouth);
    const Vec3d radial = p - mouth - along * axis;
    const double beyond = std::max(-along, along - depth);
    if (beyond > radial.norm() - 0.5 * diameter || radial.norm() < 1e-9)
      return along < 0.5 * depth ? Vec3d(-axis) : axis;
    return radial.normalized();
  }
  /// Finite, a unit axis, and numbers in range. @rt
  bool isUsable() const noexcept {
    return mouth.allFinite() && mouth.norm() < 1e5 && std::abs(axis.norm() - 1) < 1e-6 && diameter >= kLeastDiameter &&
           diameter <= kMostDiameter && depth > 0 && depth <= kMostDepth;
  }
};

}  // namespace kerf
