// Kinematics of the WoodenHaptics arm: a body that turns about the vertical, and two links driven in parallel.
//
//   angle of a body   t = direction * 2 pi count / cpr * capstan / body   diameters
//   r = Lb sin tB + Lc sin tC
//   x = r cos tA - ox,  y = r sin tA - oy,  z = La + Lb cos tB - Lc cos tC - oz
//   torque of a motor = J^T F, J = d(x, y, z) / d(angle of the motor);  current = torque / kt
//
// In its home pose link B stands upright and link C is level, tB = 0 and tC = pi / 2, away from the body.
#pragma once

#include <array>

#include "geometry/base/types.h"

namespace kerf {

struct WoodyModel {
  std::array<double, 3> counts_per_turn = {2000, 2000, 2000};
  std::array<double, 3> direction = {1, 1, 1};   ///< 1 or -1: of a body for the counts of its motor
  double capstan = 10;                           ///< mm, diameter
  std::array<double, 3> body = {160, 120, 120};  ///< mm, diameter
  double la = 80, lb = 205, lc = 245;            ///< mm
  Vec3d origin = {220, 0, 80};                   ///< mm
  double newton_mm_per_ampere = 25.9;
  double most_force = 5, most_stiffness = 1;  ///< N, N/mm
  std::array<int, 3> home = {0, 0, 6000};     ///< counts, when it stands in its home pose
};

struct WoodyPose {
  Vec3d position = Vec3d::Zero();                      ///< mm
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();  ///< mm per radian of each motor
};

/// The same arm behind the firmware of 2026 for a serial port, which counts two motors the other way.
inline WoodyModel serialWoody() noexcept {
  WoodyModel out;
  out.direction = {1, -1, -1};
  out.home = {0, 0, -6000};
  return out;
}

/// @rt safe.
WoodyPose woodyPose(const WoodyModel& model, const std::array<int, 6>& counts) noexcept;
/// mA of the three motors. @rt safe.
Vec3d woodyCurrents(const WoodyModel& model, const Eigen::Matrix3d& jacobian, const Vec3d& force) noexcept;

/// Most current that is ever asked for, mA: larger forces keep their direction.
inline constexpr double kWoodyMostCurrent = 2000;

}  // namespace kerf
