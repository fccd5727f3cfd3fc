#include "sim/step/coupling.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "sim/step/core_contact.h"

namespace kerf {
namespace {

Vec3d clampedVector(const Vec3d& wanted, const Vec3d& last, double limit, double change) {
  if (!wanted.allFinite()) return Vec3d::Zero();
  Vec3d v = wanted;
  if (const double size = v.norm(); size > limit) v *= limit / size;
  const Vec3d step = v - last;
  if (const double size = step.norm(); size > change) v = last + step * (change / size);
  return v;
}

Vec3d saturated(const Vec3d& stretch, double limit) {
  const double size = stretch.norm();
  return size > limit ? Vec3d(stretch * (limit / size)) : stretch;
}

// Solves with the grip of friction, or with its drag while it slides.
template <class Solve>
Vector6d heldBy(Vector6d& grip, const ToolBody& body, const ContactSums& contact, const Matrix6d& a, const Vector6d& b,
                double dt, const Solve& solve) {
  if (!(contact.drag > 0) || contact.normal_drag.isZero(0)) {
    grip.setZero();
    return solve(a, b);
  }

  Vector6d before;
  before << body.velocity, body.angular;
  const Matrix6d drag = contact.dragMatrix(), along = drag - contact.normal_drag;
  const Matrix6d spring = kGrip / contact.drag * along;
  const auto sizeOf = [&](const Matrix6d& m, const Vector6d& motion) {
    return std::sqrt(std::max(0.0, motion.dot(m * motion) / contact.drag));
  };
  const double most = contact.drag * std::max(sizeOf(drag, before), kStillSpeed) / kGrip;  // mu N / k
  const auto slide = [&] {
    const Vector6d v = solve(a, b);
    grip = contact.drag / kGrip * v;
    if (const double size = sizeOf(along, grip); size > most) grip *= most / size;
    return v;
  };

  if (sizeOf(along, before) > kStillSpeed) {
    const Vector6d anchored = grip, v = slide();
    if (sizeOf(along, v) > kStillSpeed) return v;
    grip = anchored;
  }
  const Vector6d v = solve(a - dt * along + dt * dt * spring, b - dt * spring * grip);
  const Vector6d moved = grip + dt * v;
  if (!(sizeOf(along, moved) <= most)) return slide();
  grip = moved;
  return v;
}

}  // namespace

Vec3d rotationBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) noexcept {
  Eigen::Quaterniond q = to * from.conjugate();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double s = q.vec().norm();
  // 2 atan2(s, w) / s, whose limit at s = 0 is 2 / w
  const double scale = s > 1e-9 ? 2 * std::atan2(s, q.w()) / s : 2 / q.w();
  return scale * q.vec();
}

Eigen::Quaterniond rotated(const Eigen::Quaterniond& from, const Vec3d& rotation) noexcept {
  const double angle = rotation.norm(), half = 0.5 * angle;
  const double scale = angle > 1e-9 ? std::sin(half) / angle : 0.5;
  Eigen::Quaterniond q;
  q.w() = std::cos(half);
  q.vec() = scale * rotation;
  return (q * from).normalized();
}

Vector6d springPull(const Rigid3& pose, const DeviceMotion& device, const CouplingSettings& s) noexcept {
  Vector6d pull;
  pull.head<3>() = s.stiffness * saturated(device.pose.translation - pose.translation, s.force_limit / s.stiffness);
  pull.tail<3>() = s.turn_stiffness *
                   saturated(rotationBetween(pose.rotation, device.pose.rotation), s.torque_limit / s.turn_stiffness);
  return pull;
}

Wrench advance(ToolBody& body, const DeviceMotion& device, const ContactSums& contact, const Wrench& own_drag,
               const CouplingSettings& s, double head_reach, double longest, double dt, CoreContact* core,
               Vector6d* grip) noexcept {
  const double mass = s.mass(), inertia = s.inertia();
  Matrix6d a = dt * contact.dragMatrix() + dt * dt * contact.stiffness;
  Vector6d b;
  const Vector6d pull = springPull(body.pose, device, s);
  const bool has_core = core && !core->isEmpty();
  const bool is_free = !has_core && a.isZero(0) && contact.force_next.isZero(0) && own_drag.force.isZero(0);
  b.head<3>() =
      mass * body.velocity + dt * (pull.head<3>() + s.damping * device.velocity + contact.force_next + own_drag.force);
  b.tail<3>() = inertia * body.angular +
                dt * (pull.tail<3>() + s.turn_damping * device.angular + contact.torque_next + own_drag.torque);
  a.diagonal().head<3>().array() += mass + dt * s.damping + dt * dt * s.stiffness;
  a.diagonal().tail<3>().array() += inertia + dt * s.turn_damping + dt * dt * s.turn_stiffness;
  const auto solve = [&](const Matrix6d& of, const Vector6d& to) {
    return has_core ? core->solve(of, to, dt) : Vector6d(of.ldlt().solve(to));
  };
  const Vector6d v = grip ? heldBy(*grip, body, contact, a, b, dt, solve) : solve(a, b);
  if (!(a.allFinite() && b.allFinite() && v.allFinite())) {
    body.velocity.setZero();
    body.angular.setZero();
    if (grip) grip->setZero();
    return {};
  }

  // Change of momentum by forces other than the coupling.
  const Vec3d moved = v.head<3>(), turned = v.tail<3>();
  Wrench did;
  if (!is_free) {
    did.force = mass / dt * (moved - body.velocity) - pull.head<3>() - s.damping * (device.velocity - moved) +
                dt * s.stiffness * moved;
    did.torque = inertia / dt * (turned - body.angular) - pull.tail<3>() - s.turn_damping * (device.angular - turned) +
                 dt * s.turn_stiffness * turned;
  }
  body.velocity = moved;
  body.angular = turned;
  travel(body, head_reach, longest, dt);
  return did;
}

double travel(ToolBody& body, double head_reach, double longest, double dt) noexcept {
  const double motion = dt * (body.velocity.norm() + head_reach * body.angular.norm());
  const double kept = motion > longest ? longest / motion : 1;
  if (kept < 1) {
    body.velocity *= kept;
    body.angular *= kept;
  }
  body.pose.translation += dt * body.velocity;
  body.pose.rotation = rotated(body.pose.rotation, dt * body.angular);
  return kept;
}

Wrench couplingWrench(const ToolBody& body, const DeviceMotion& device, const CouplingSettings& s) noexcept {
  return {
      s.stiffness * (body.pose.translation - device.pose.translation) + s.damping * (body.velocity - device.velocity),
      s.turn_stiffness * rotationBetween(device.pose.rotation, body.pose.rotation) +
          s.turn_damping * (body.angular - device.angular)};
}

Wrench clamped(const Wrench& wanted, const Wrench& last, const CouplingSettings& s, double dt) noexcept {
  return {clampedVector(wanted.force, last.force, s.force_limit, s.force_rate * dt),
          clampedVector(wanted.torque, last.torque, s.torque_limit, s.torque_rate * dt)};
}

}  // namespace kerf
