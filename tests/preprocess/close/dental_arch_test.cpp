#include "preprocess/close/dental_arch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "preprocess/demo/demo_arch.h"
#include "preprocess/demo/demo_molar.h"
#include "preprocess/demo/demo_teeth.h"
#include "tests/preprocess/solid_checks.h"

namespace kerf::dental_arch_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

const Mesh& scan() {
  static const Mesh mesh = demoArch({.edge_mm = 0.6})->mesh;
  return mesh;
}

Mesh moved(Mesh mesh, const Rigid3& pose) {
  for (Vec3d& p : mesh.vertices) p = pose * p;
  return mesh;
}

/// The part of a mesh selected by `keeps`.
template <class Keeps>
Mesh partOf(Mesh mesh, const Keeps& keeps) {
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return !keeps(mesh.vertices[t[0]]); });
  return mesh;
}

std::optional<DentalArch> archOf(const Mesh& mesh, const Vec3d& up) {
  const auto plane = findOcclusalPlane(mesh, up);
  return plane ? findDentalArch(mesh, *plane) : std::nullopt;
}

double degreesBetween(const Vec3d& a, const Vec3d& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)) / kDegree; }

// The teeth of the demo arch have their own frames: x mesial, y buccal, z occlusal. Teeth lean and are rotated a little
// in their row: a curve comes within 20 degrees.
TEST(DentalArch, TellsTheSidesOfEveryToothHoweverTheScanIsStored) {
  constexpr double kNear = 20;  // degrees
  for (const Vec3d& axis : {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(0.2, -1, 0.4), Vec3d(0, 0, 3), Vec3d(2, 1, -1)}) {
    const Rigid3 stored{axis.isZero() ? Eigen::Quaterniond::Identity()
                                      : Eigen::Quaterniond(Eigen::AngleAxisd(axis.norm(), axis.normalized())),
                        10 * axis};
    const auto arch = archOf(moved(scan(), stored), stored.rotation * Vec3d(0.1, 0.1, 1));
    ASSERT_TRUE(arch) << axis.transpose();
    EXPECT_LT(degreesBetween(arch->front, stored.rotation * -Vec3d::UnitY()), 5) << axis.transpose();

    for (const internal::ToothPose& tooth : internal::lowerRow())
      for (const double left : {1.0, -1.0}) {
        const auto inScan = [&](Vec3d v) {
          v.x() *= left;
          return Vec3d(stored.rotation * v);
        };
        const Eigen::Quaterniond of_tooth = tooth.T_tooth_jaw.rotation.conjugate();
        const ToothSides sides = arch->sidesAt(inScan(tooth.middle) + stored.translation);
        const int number = tooth.tooth->position;
        EXPECT_LT(degreesBetween(sides.mesial, inScan(of_tooth * Vec3d::UnitX())), kNear) << number << ' ' << left;
        EXPECT_LT(degreesBetween(sides.buccal, inScan(of_tooth * Vec3d::UnitY())), kNear) << number << ' ' << left;
        EXPECT_LT(degreesBetween(sides.occlusal, inScan(of_tooth * Vec3d::UnitZ())), kNear) << number << ' ' << left;
        EXPECT_NEAR(sides.mesial.dot(sides.buccal), 0, 1e-9);
        EXPECT_NEAR(sides.mesial.dot(sides.occlusal), 0, 1e-9);
        EXPECT_NEAR(sides.buccal.norm(), 1, 1e-9);
      }
  }
}

TEST(DentalArch, ItsCurveRunsAlongTheTeeth) {
  const auto arch = archOf(scan(), Vec3d::UnitZ());
  ASSERT_TRUE(arch);
  constexpr double kHalfATooth = 3;  // mm
  for (const internal::ToothPose& tooth : internal::lowerRow())
    for (const double left : {1.0, -1.0}) {
      const Vec3d top = tooth.T_tooth_jaw.inverse() * Vec3d(0, 0, tooth.tooth->crown);
      const Vec3d p(left * top.x(), top.y(), top.z());
      const Vec3d off = p - arch->curve[arch->nearest(p)];
      EXPECT_LT(std::hypot(off.x(), off.y()), kHalfATooth) << tooth.tooth->position << ' ' << left;
    }
}

TEST(DentalArch, WhatIsNoFullArchTellsNothing) {
  const auto plane = findOcclusalPlane(scan(), Vec3d::UnitZ());
  ASSERT_TRUE(plane);
  ASSERT_TRUE(findDentalArch(scan(), *plane));

  const Mesh quadrant = partOf(scan(), [](const Vec3d& p) { return p.x() > 2; });
  EXPECT_FALSE(findDentalArch(quadrant, *plane));
  const Mesh front = partOf(scan(), [](const Vec3d& p) { return p.y() < 8; });
  EXPECT_FALSE(findDentalArch(front, *plane));
  const Mesh block = box({-30, -10, -20}, {30, 50, 0});
  EXPECT_FALSE(findDentalArch(block, *plane)) << "a plate is no row";
  EXPECT_FALSE(findDentalArch(demoMolar(0.5), {Vec3d::UnitZ(), {0, 0, 7.5}, 5, 0.1}));
  EXPECT_FALSE(findDentalArch(Mesh{}, *plane));
}

}  // namespace
}  // namespace kerf::dental_arch_test
