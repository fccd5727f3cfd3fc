// Where in the scene the hand of a device is: its frame to the world's.
#pragma once

#include "sim/hand/device_profile.h"

namespace kerf {

/// world = offset + scale * turn * device; a force goes back by the turn alone. @rt safe, one thread.
class WorkspaceMap {
 public:
  /// @param turn  from the device's axes to the world's.   @param scale  mm of the world for a mm of the hand, > 0:
  /// below 1 fine work, and the device feels stiffer things softer by the same.
  explicit WorkspaceMap(const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity(), double scale = 1)
      : turn_(turn.normalized()), scale_(scale) {}

  Rigid3 toWorld(const Rigid3& device) const noexcept {
    return {(turn_ * device.rotation * grip_).normalized(), offset_ + scale_ * (turn_ * device.translation)};
  }
  Vec3d toDevice(const Vec3d& world) const noexcept { return turn_.conjugate() * world; }
  /// From now on this pose of the device is that one of the world: at the start, after a clutch was held, when the tool
  /// was put elsewhere.
  void meet(const Rigid3& device, const Rigid3& world) noexcept {
    grip_ = ((turn_ * device.rotation).conjugate() * world.rotation).normalized();
    offset_ = world.translation - scale_ * (turn_ * device.translation);
  }
  double scale() const noexcept { return scale_; }
  /// The same turn and scale; the offset is another matter.
  bool isAlike(const WorkspaceMap& other) const noexcept {
    return scale_ == other.scale_ && turn_.coeffs() == other.turn_.coeffs();
  }
  /// The device as the world sees it: what a coupling there has to be made for. A mm of the world is 1 / scale of the
  /// hand's, and a N is a N.
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
