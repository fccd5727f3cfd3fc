// Limits a computed force before it reaches the motors of a device.
#pragma once

#include <algorithm>

#include "geometry/base/types.h"

namespace kerf {

struct ForceLimits {
  double force = 3;     ///< N, largest force; its direction is kept
  double rate = 500;    ///< N/s: fastest change. Exception: a decrease along the current force is immediate
  double ramp_s = 0.5;  ///< after arm() the force fades in over this long
};

/// For forces, or for torques in N mm. Disarmed at first: zero. A force that is not finite disarms it, until arm() is
/// called again. @rt safe, one thread.
class ForceGuard {
 public:
  explicit ForceGuard(const ForceLimits& limits = {}) : limits_(limits) {}
  void limit(const ForceLimits& limits) noexcept { limits_ = limits; }
  void arm() noexcept;
  /// Zero from now on, without a ramp.
  void disarm() noexcept;
  bool isArmed() const noexcept { return is_armed_; }
  /// A force that was not finite disarmed it.
  bool hasFault() const noexcept { return has_fault_; }
  void forgetFault() noexcept { has_fault_ = false; }
  /// The same effect as a force that is not finite.
  void fail() noexcept {
    disarm();
    has_fault_ = true;
  }
  /// Share of the fading-in, 0 to 1; 0: not armed.
  double ramp() const noexcept { return is_armed_ ? std::min(1.0, armed_for_ / limits_.ramp_s) : 0; }
  /// The last force was limited in size or in rate.
  bool isClamped() const noexcept { return is_armed_ && is_clamped_; }

  /// @param wanted  N.   @param dt  since the last call, s.   @return  the allowed force.
  Vec3d pass(const Vec3d& wanted, double dt) noexcept;

 private:
  ForceLimits limits_;
  Vec3d last_ = Vec3d::Zero();
  double armed_for_ = 0;  // s
  bool is_armed_ = false, has_fault_ = false, is_clamped_ = false;
};

}  // namespace kerf
