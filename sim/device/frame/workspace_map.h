// Maps the frame of a device to the world.
#pragma once

#include "sim/hand/device_profile.h"

namespace kerf {

/// world = offset + scale * turn * device; a force goes back by the turn alone. @rt safe, one thread.
class WorkspaceMap {
 public:
  /// @param turn  from the device's axes to the world's.   @param scale  mm of the world for a mm of the hand, > 0:
  /// below 1 for fine work; stiff contacts then feel softer by the same factor.
  explicit WorkspaceMap(const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity(), double scale = 1)
      : turn_(turn.normalized()), scale_(scale) {}

  Rigid3 toWorld(const Rigid3& device) const noexcept {
    return {(turn_ * device.rotation * grip_).normalized(), offset_ + scale_ * (turn_ * device.translation)};
  }
  Vec3d toDevice(const Vec3d& world) const noexcept { return turn_.conjugate() * world; }
  /// Matches this pose of the device with that one of the world from now on: at the start, after a clutch, when the
  /// tool was placed elsewhere.
  void meet(const Rigid3& device, const Rigid3& world) noexcept {
    grip_ = ((turn_ * device.rotation).conjugate() * world.rotation).normalized();
    offset_ = world.translation - scale_ * (turn_ * device.translation);
  }
  double scale() const noexcept { return scale_; }
  /// The same turn and scale; ignores the offset.
  bool isAlike(const WorkspaceMap& other) const noexcept {
    return scale_ == other.scale_ && turn_.coeffs() == other.turn_.coeffs();
  }
  /// The device's profile in world units, for a coupling there. A mm of the world is 1 / scale of the hand's; a N is a
  /// N.
  DeviceProfile inWorld(DeviceProfile profile) const noexcept {
    profile.mass_kg /= scale_;
    profile.encoder_mm *= scale_;
    return profile;
  }

 private:
  Eigen::Quaterniond turn_;
  double scale_;
  Eigen::Quaterniond grip_ = Eigen::Quaterniond::Identity();  // of the tool in the hand
  Vec3d offset_ = Vec3d::Zero();
};

}  // namespace kerf
