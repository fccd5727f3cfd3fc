#include "bench/scenes/poses.h"

namespace kerf::scenes {
namespace {

Eigen::Quaterniond rotationOf(const Vec3d& x, const Vec3d& y, const Vec3d& z) {
  Eigen::Matrix3d axes;
  axes.col(0) = x;
  axes.col(1) = y;
  axes.col(2) = z;
  return Eigen::Quaterniond(axes);
}

}  // namespace

Rigid3 turned(double angle, const Vec3d& axis, const Vec3d& shift) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())), shift};
}

Rigid3 askew() { return turned(0.3, {1, 2, 3}); }

Eigen::Quaterniond teethDown() { return rotationOf(Vec3d::UnitZ(), -Vec3d::UnitY(), Vec3d::UnitX()); }

Eigen::Quaterniond flankDown() { return rotationOf(Vec3d::UnitX(), Vec3d::UnitZ(), -Vec3d::UnitY()); }

DeviceSample sampleAt(const Rigid3& pose, double pedal) {
  DeviceSample sample;
  sample.T_world_device = pose;
  sample.pedal = pedal;
  return sample;
}

}  // namespace kerf::scenes
