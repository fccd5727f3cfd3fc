// Kinematics of the WoodenHaptics arm: a body that turns about the vertical, and two links driven in parallel. SI
// units.
//
//   angle of a body   t = direction * 2 pi count / cpr * capstan / body   diameters
//   r = Lb sin tB + Lc sin tC
//   x = r cos tA - ox,  y = r sin tA - oy,  z = La + Lb cos tB - Lc cos tC - oz
//   torque of a motor = J^T F, J = d(x, y, z) / d(angle of the motor);  current = torque / kt
//
// In its home pose link B stands upright and link C is level, tB = 0 and tC = pi / 2, away from the body. Dimensions
// are those of the arm of 2015 as published by the project; others differ in their torque constants and gears.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bridges/kerf_link.h"

namespace bridge {

using Counts = std::array<int, 3>;  ///< of the encoders of three motors

struct WoodyModel {
  Vec3 direction = {1, 1, 1};  ///< 1 or -1: of a body for the counts of its motor
  Counts home = {0, 0, 6000};  ///< in its home pose

  static constexpr double kCountsPerTurn = 2000;
  static constexpr double kCapstan = 0.010;                    ///< m, diameter
  static constexpr Vec3 kBody = {0.160, 0.120, 0.120};         ///< m, diameter
  static constexpr double kA = 0.080, kB = 0.205, kC = 0.245;  ///< m, La, Lb, Lc
  static constexpr Vec3 kOrigin = {0.220, 0, 0.080};           ///< m
  static constexpr double kNewtonMetrePerAmpere = 0.0259;
  static constexpr double kMostCurrent = 2000;  ///< mA: larger forces keep their direction
};
/// The same arm behind the firmware for a serial port, which counts two motors the other way.
inline constexpr WoodyModel kSerialWoody{{1, -1, -1}, {0, 0, -6000}};

struct WoodyPose {
  Vec3 position{};
  std::array<Vec3, 3> per_motor{};  ///< m of the tip for a radian of each motor: columns of the Jacobian
};

inline WoodyPose woodyPose(const WoodyModel& model, const Counts& counts) {
  using M = WoodyModel;
  Vec3 t{}, gear{};
  for (std::size_t n = 0; n < 3; ++n) {
    gear[n] = model.direction[n] * M::kCapstan / M::kBody[n];
    t[n] = gear[n] * 2 * std::numbers::pi * counts[n] / M::kCountsPerTurn;
  }
  const double ca = std::cos(t[0]), sa = std::sin(t[0]);
  const double r = M::kB * std::sin(t[1]) + M::kC * std::sin(t[2]);
  const double rb = M::kB * std::cos(t[1]), rc = M::kC * std::cos(t[2]);

  WoodyPose out;
  out.position = {r * ca - M::kOrigin[0], r * sa - M::kOrigin[1],
                  M::kA + M::kB * std::cos(t[1]) - M::kC * std::cos(t[2]) - M::kOrigin[2]};
  out.per_motor[0] = {gear[0] * -r * sa, gear[0] * r * ca, 0};
  out.per_motor[1] = {gear[1] * rb * ca, gear[1] * rb * sa, gear[1] * -M::kB * std::sin(t[1])};
  out.per_motor[2] = {gear[2] * rc * ca, gear[2] * rc * sa, gear[2] * M::kC * std::sin(t[2])};
  return out;
}

/// mA of the three motors. A force that is not finite: zero.
inline Vec3 woodyCurrents(const WoodyPose& pose, const Vec3& force) {
  Vec3 out{};
  double most = 0;
  for (std::size_t n = 0; n < 3; ++n) {
    const Vec3& way = pose.per_motor[n];
    const double torque = way[0] * force[0] + way[1] * force[1] + way[2] * force[2];
    out[n] = 1000 / WoodyModel::kNewtonMetrePerAmpere * torque;
    most = std::max(most, std::abs(out[n]));
    if (!std::isfinite(out[n])) return {};
  }
  if (most > WoodyModel::kMostCurrent)
    for (double& current : out) current *= WoodyModel::kMostCurrent / most;
  return out;
}

}  // namespace bridge
