// Virtual coupling: the tool is a rigid body of its own, tied to the device by a spring and damper in six degrees of
// freedom (after Colgate, Stanley & Brown, IROS 1995; McNeely, Puterbaugh & Troy, SIGGRAPH 1999).
//
// The body is integrated implicitly with the contact's own stiffness and drag, so that contact may be a thousand times
// stiffer than any device can render: the hand feels the coupling.
#pragma once

#include "sim/step/contact.h"

namespace kerf {

class CoreContact;

/// For a force-feedback device couplingFor() in sim/hand/device_profile.h derives these from its profile.
struct CouplingSettings {
  double stiffness = 1.0;        ///< N/mm. Above about 2 a common 1 kHz device hums in a loose hand
  double damping = 0.002;        ///< N s/mm (2 N s/m), while the drive stands still. More amplifies the encoder's steps
  double turn_stiffness = 1000;  ///< N mm/rad
  double turn_damping = 2;       ///< N mm s/rad, while the drive stands still
  double running_damping = 0.002;   ///< N s/mm, while the drive turns
  double running_turn_damping = 2;  ///< N mm s/rad, while the drive turns
  /// Mass of the virtual tool. It swings on the coupling with the damping ratio B / (2 sqrt(K m)): 0.22 at 20 g, 0.11
  /// at the 80 g of a handpiece, which 1 N would carry 0.9 mm in 14 ms, not 1.3.
  double mass_kg = 0.02;
  double gyration_mm = 10;     ///< its radius of gyration
  double filter_hz = 100;      ///< first-order low-pass of the device's velocity
  double force_limit = 8;      ///< N
  double torque_limit = 300;   ///< N mm
  double force_rate = 2000;    ///< N/s: largest rate of change
  double torque_rate = 60000;  ///< N mm/s

  /// Settings for a turning or a resting drive.
  CouplingSettings at(bool drive_turns) const {
    CouplingSettings now = *this;
    if (drive_turns) {
      now.damping = running_damping;
      now.turn_damping = running_turn_damping;
    }
    return now;
  }
  double mass() const { return mass_kg * 1e-3; }                         ///< t: 1 N = 1 t mm/s^2
  double inertia() const { return mass() * gyration_mm * gyration_mm; }  ///< t mm^2
};

/// The virtual tool, world frame, about its tip.
struct ToolBody {
  Rigid3 pose;                     ///< T_world_tool, mm
  Vec3d velocity = Vec3d::Zero();  ///< of the tip, mm/s
  Vec3d angular = Vec3d::Zero();   ///< rad/s
};

/// Device motion for the coupling, world frame.
struct DeviceMotion {
  Rigid3 pose;
  Vec3d velocity = Vec3d::Zero(), angular = Vec3d::Zero();  ///< filtered
};

/// Shortest rotation vector that takes `from` to `to`, world frame, rad.
Vec3d rotationBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) noexcept;
Eigen::Quaterniond rotated(const Eigen::Quaterniond& from, const Vec3d& rotation) noexcept;

/// Pull of the coupling's springs on the tool, N and N mm. Beyond the limits of force and torque they give way: a hand
/// that runs off does not pull the tool through a wall. @rt
Vector6d springPull(const Rigid3& T_world_tool, const DeviceMotion& device, const CouplingSettings& settings) noexcept;

/// Moves the body by its velocities over dt. Scales motion and velocities down so that no part of the cutting head
/// moves farther than `longest_mm`.  @return the factor, 1 at most. @rt
double travel(ToolBody& body, double head_reach_mm, double longest_mm, double dt) noexcept;

/// One implicit Euler step of the body: (M + dt (B + D) + dt^2 (K + J)) V' = M V + dt (K e + B V_d + F + F_own). F and
/// J are of the mean contact force over the next evaluation: the hand's pull equals the pressure on a tool at rest in
/// tissue, for any erosion during an evaluation.
/// @param contact  world frame: uses force_next, stiffness and drag.   @param own_drag  of the tool's own motion.
/// @param longest  mm: largest motion of any part of the cutting head in one step; the motion is scaled down to it.
/// @param core  further pushes, solved together with the velocity; null: none.
/// @param grip  of friction on a tool at rest; null: drag only. An elastic and plastic spring (after Hayward &
///   Armstrong, ISER 2000) of k = kGrip: the tool's motion g since its anchor pulls with k T g, T = (D - D_n) / drag,
///   D_n ContactSums::normal_drag. Up to mu N it holds, and nothing creeps. Beyond, the tool slides under D, and the
///   anchor follows. k does not change with the load, so that it adds no energy.
/// @return wrench of contact and drag on the body, mean over dt, before its motion is scaled down. The overlap at a
/// pose gives too much at an impact: 27 N for a flat of 5 mm^2 at 25 mm/s, which 0.8 N stop. At lift-off the implicit
/// step may hold the tool back for some ms. Zero to the bit without contact, or if any input is not finite.   @rt
Wrench advance(ToolBody& body, const DeviceMotion& device, const ContactSums& contact, const Wrench& own_drag,
               const CouplingSettings& settings, double head_reach_mm, double longest_mm, double dt,
               CoreContact* core = nullptr, Vector6d* grip = nullptr) noexcept;

inline constexpr double kGrip = 300;  ///< N/mm: as stiff as the core in hard tissue

/// Wrench of the coupling on the hand: spring and damper from device to tool. Not clamped. @rt
Wrench couplingWrench(const ToolBody& body, const DeviceMotion& device, const CouplingSettings& settings) noexcept;

/// Limits the size first, then the change since `last`; a value that is not finite becomes zero. @rt
Wrench clamped(const Wrench& wanted, const Wrench& last, const CouplingSettings& settings, double dt) noexcept;

}  // namespace kerf
