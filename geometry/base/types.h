// Small value types shared by every part of Kerf. Lengths in mm, angles in rad, right-handed frames.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace kerf {

using Vec3d = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;
using Vec3i = Eigen::Vector3i;
using Rgba8 = std::array<std::uint8_t, 4>;

/// The nearest float32 number, as files hold it. Through memory: g++ 12 turns a vectorised double -> float -> double
/// (plain or Eigen's p.cast<float>().cast<double>()) into nothing at all at -O2.
inline double roundedToFloat(double x) {
  volatile float f = static_cast<float>(x);
  return f;
}
/// The nearest point with float32 coordinates.
inline Vec3d roundedToFloat(const Vec3d& p) {
  return {roundedToFloat(p[0]), roundedToFloat(p[1]), roundedToFloat(p[2])};
}

/// Axis-aligned box, mm. Empty (min > max) until a point is added.
struct Box3 {
  Vec3d min = Vec3d::Constant(std::numeric_limits<double>::infinity());
  Vec3d max = Vec3d::Constant(-std::numeric_limits<double>::infinity());

  bool isEmpty() const { return !(min.array() <= max.array()).all(); }
  void add(const Vec3d& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  void add(const Box3& b) {
    min = min.cwiseMin(b.min);
    max = max.cwiseMax(b.max);
  }
  void grow(double margin) {
    min.array() -= margin;
    max.array() += margin;
  }
  bool contains(const Vec3d& p) const { return (p.array() >= min.array()).all() && (p.array() <= max.array()).all(); }
  Vec3d size() const { return isEmpty() ? Vec3d(Vec3d::Zero()) : Vec3d(max - min); }
  Vec3d center() const { return 0.5 * (min + max); }

  /// Corner n of eight: bit 0 of n chooses the end along x, bit 1 along y, bit 2 along z; a set bit the upper end. @rt
  Vec3d corner(int n) const noexcept {
    return {(n & 1 ? max : min)[0], (n & 2 ? max : min)[1], (n & 4 ? max : min)[2]};
  }
  /// Box around this box after a move: around pose * corner(n). Larger than the moved solid after a rotation. @rt
  /// @param pose  a Rigid3, a rotation or a scaling.   @pre not empty.
  template <class Pose>
  Box3 transformed(const Pose& pose) const noexcept {
    Box3 box;
    for (int n = 0; n < 8; ++n) box.add(Vec3d(pose * corner(n)));
    return box;
  }
};

/// A plane; heights are measured along the normal.
struct Plane {
  Vec3d point = Vec3d::Zero();    ///< mm
  Vec3d normal = Vec3d::UnitZ();  ///< unit
  double height(const Vec3d& p) const { return normal.dot(p - point); }
};

/// Rigid pose: x_parent = rotation * x_child + translation. `T_object_tool` maps tool coordinates to the object's.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit
  Vec3d translation = Vec3d::Zero();                             ///< mm

  Vec3d operator*(const Vec3d& p) const { return rotation * p + translation; }
  Rigid3 operator*(const Rigid3& o) const {
    return {(rotation * o.rotation).normalized(), rotation * o.translation + translation};
  }
  Rigid3 inverse() const { return {rotation.conjugate(), -(rotation.conjugate() * translation)}; }

  static constexpr double kMostTranslation = 1e5;  ///< mm; a larger coordinate is an error
  /// True if a pose from outside (a device, a file) is valid: finite, the quaternion of unit length within 1e-6, nearer
  /// than kMostTranslation. @rt
  bool isUsable() const noexcept {
    return translation.allFinite() && rotation.coeffs().allFinite() && std::abs(rotation.norm() - 1) < 1e-6 &&
           translation.norm() < kMostTranslation;
  }
};

}  // namespace kerf
