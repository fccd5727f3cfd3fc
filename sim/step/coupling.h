// Virtual coupling: the tool is a rigid body of its own, tied to the device by a spring and damper in six degrees of
// freedom (after Colgate, Stanley & Brown, IROS 1995; McNeely, Puterbaugh & Troy, SIGGRAPH 1999).
//
// The body is integrated implicitly with the contact's own stiffness and drag, so that contact may be a thousand times
// stiffer than anything a device could render: what the hand meets is the coupling.
#pragma once

#include "sim/step/contact.h"

namespace kerf {

class CoreContact;

/// For a force-feedback device these follow from its profile: couplingFor() in sim/hand/device_profile.h.
struct CouplingSettings {
  double stiffness = 1.0;        ///< N/mm. Above about 2 a common 1 kHz device hums in a loose hand
  double damping = 0.002;        ///< N s/mm (2 N s/m), while the drive stands still. More amplifies the encoder's steps
  double turn_stiffness = 1000;  ///< N mm/rad
  double turn_damping = 2;       ///< N mm s/rad, while the drive stands still
  double running_damping = 0.002;   ///< N s/mm, while the drive turns
  double running_turn_damping = 2;  ///< N mm s/rad, while the drive turns
  /// Of the virtual tool. It swings on the coupling with the damping ratio B / (2 sqrt(K m)): 0.22 at 20 g, 0.11 at the
  /// 80 g of a handpiece, which 1 N would carry 0.9 mm in 14 ms, not 1.3.
  double mass_kg = 0.02;
  double gyration_mm = 10;     ///< its radius of gyration
  double filter_hz = 100;      ///< first-order low-pass of the device's velocity
  double force_limit = 8;      ///< N
  double torque_limit = 300;   ///< N mm
  double force_rate = 2000;    ///< N/s: no faster change
  double torque_rate = 60000;  ///< N mm/s

  /// As it is while the drive turns, or stands still.
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

/// The device as the coupling sees it, world frame.
struct DeviceMotion {
  Rigid3 pose;
  Vec3d velocity = Vec3d::Zero(), angular = Vec3d::Zero();  ///< filtered
};

/// Shortest rotation vector that takes `from` to `to`, world frame, rad.
Vec3d rotationBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) noexcept;
Eigen::Quaterniond rotated(const Eigen::Quaterniond& from, const Vec3d& rotation) noexcept;

/// Of the coupling's springs on the tool, N and N mm. Beyond the limits of force and torque they give way: a hand that
/// runs off does not pull the tool through a wall. @rt
Vector6d springPull(const Rigid3& T_world_tool, const DeviceMotion& device, const CouplingSettings& settings) noexcept;

/// Moves the body by its velocities over dt; no part of the cutting head farther than `longest_mm`, to which motion and
/// velocities are scaled down.  @return by how much, 1 at most. @rt
double travel(ToolBody& body, double head_reach_mm, double longest_mm, double dt) noexcept;

/// One implicit Euler step of the body: (M + dt (B + D) + dt^2 (K + J)) V' = M V + dt (K e + B V_d + F + F_own).
/// F and J are of the mean contact force over the next evaluation: a tool at rest in what it cuts is pressed with as
/// much as the hand pulls, however much erodes in an evaluation.
/// @param contact  world frame: force_next, stiffness and drag are used.   @param own_drag  of the tool's own motion.
/// @param longest  mm: no part of the cutting head moves farther in one step; the motion is scaled down to it.
/// @param core  what else pushes, solved for together with the velocity; null: nothing.
/// @param grip  of friction on a tool at rest; null: it drags alone. An elastic and plastic spring (after Hayward &
/// Armstrong, ISER 2000) of k = kGrip: the tool's motion g since its anchor pulls with k T g, T = (D - D_n) / drag, D_n
/// ContactSums::normal_drag. Up to mu N it holds, and nothing creeps; beyond, the tool slides under D as ever, and the
/// anchor follows. k does not change with the load, so no energy comes of it.
/// @return what contact and drag did to the body, mean over dt, before its motion is scaled down. Overlap at a pose
/// says more where it lands: 27 N for a flat of 5 mm^2 at 25 mm/s, which 0.8 N stop. Where it lifts off, the implicit
/// step may hold it back for some ms. Zero to the bit where nothing touches, or where not all is finite.   @rt
Wrench advance(ToolBody& body, const DeviceMotion& device, const ContactSums& contact, const Wrench& own_drag,
               const CouplingSettings& settings, double head_reach_mm, double longest_mm, double dt,
               CoreContact* core = nullptr, Vector6d* grip = nullptr) noexcept;

inline constexpr double kGrip = 300;  ///< N/mm: as stiff as the core in hard tissue

/// What the coupling does to the hand: spring and damper from device to tool. Not clamped. @rt
Wrench couplingWrench(const ToolBody& body, const DeviceMotion& device, const CouplingSettings& settings) noexcept;

/// Size first, then change since `last`; a value that is not finite becomes zero. @rt
Wrench clamped(const Wrench& wanted, const Wrench& last, const CouplingSettings& settings, double dt) noexcept;

}  // namespace kerf
