// A tip that exits behind the object, and a tip that only enters a hollow.
#include "sim/run/sweep/tip_exit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/field/sample_field.h"

namespace kerf::tip_exit_test {
namespace {

double cube(const Vec3d& p, double half) { return (p.cwiseAbs() - Vec3d::Constant(half)).maxCoeff(); }

Box3 around(double half) {
  Box3 out;
  out.add(Vec3d::Constant(-half));
  out.add(Vec3d::Constant(half));
  return out;
}

std::optional<Vec3d> exitOf(const BrickField& field, double to_z) {
  internal::TipExit exit(field);
  exit.moveTo({Eigen::Quaterniond::Identity(), Vec3d(0.3, 0.2, 5)});
  exit.moveTo({Eigen::Quaterniond::Identity(), Vec3d(0.3, 0.2, to_z)});
  return exit.place();
}

TEST(TipExit, AClosedCavityIsNotTheFarSide) {
  const auto hollow = [](const Vec3d& p) { return std::max(cube(p, 4), -cube(p, 1.5)); };
  const BrickField field = sampleDistance(hollow, around(4), 0.1);
  EXPECT_FALSE(exitOf(field, 0)) << "in the cavity";
  const auto through = exitOf(field, -6);
  ASSERT_TRUE(through);
  EXPECT_NEAR(through->z(), -4, 0.11);
}

TEST(TipExit, BetweenTwoRootsIsTheFarSide) {
  // A bridge over a tunnel along y: material ahead, but open at both ends.
  const auto tunnel = [](const Vec3d& p) { return std::max(cube(p, 4), -(Vec3d(p.x(), 0, p.z()).norm() - 1.5)); };
  const auto place = exitOf(sampleDistance(tunnel, around(4), 0.1), 0);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->z(), 1.5, 0.15);
}

}  // namespace
}  // namespace kerf::tip_exit_test
