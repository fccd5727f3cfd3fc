#include "sim/device/frame/force_guard.h"

#include <algorithm>

namespace kerf {

void ForceGuard::arm() noexcept {
  if (is_armed_) return;
  is_armed_ = true;
  has_fault_ = false;
  armed_for_ = 0;
  last_.setZero();
}

void ForceGuard::disarm() noexcept {
  is_armed_ = false;
  last_.setZero();
}

Vec3d ForceGuard::pass(const Vec3d& wanted, double dt) noexcept {
  if (!is_armed_) return Vec3d::Zero();
  if (!wanted.allFinite()) {
    disarm();
    has_fault_ = true;
    return Vec3d::Zero();
  }
  armed_for_ += dt;
  Vec3d force = std::min(1.0, armed_for_ / limits_.ramp_s) * wanted;
  is_clamped_ = false;
  if (const double size = force.norm(); size > limits_.force) {
    force *= limits_.force / size;
    is_clamped_ = true;
  }

  // A decrease towards zero along the current force is free; the increase is limited in rate.
  const double old = last_.squaredNorm();
  const Vec3d nearer = old > 0 ? Vec3d(std::clamp(force.dot(last_) / old, 0.0, 1.0) * last_) : last_;
  Vec3d change = force - nearer;
  if (const double size = change.norm(), most = limits_.rate * dt; size > most) {
    change *= most / size;
    is_clamped_ = true;
  }
  last_ = nearer + change;
  if (const double size = last_.norm(); size > limits_.force) last_ *= limits_.force / size;
  return last_;
}

}  // namespace kerf
