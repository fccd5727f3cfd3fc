#include "ui/app/upright.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/preprocess/solid_checks.h"

namespace kerf {
namespace {

// The upper half of a ball on a flat plate, its top towards +z.
Mesh dome(bool has_plate) {
  Mesh m = ball(40, 80, 10);
  for (Vec3d& p : m.vertices) p.z() = std::max(p.z(), 0.0);
  std::erase_if(m.triangles, [&](const Triangle& f) {
    const bool is_flat = m.vertices[f[0]].z() == 0 && m.vertices[f[1]].z() == 0 && m.vertices[f[2]].z() == 0;
    return is_flat && !has_plate;
  });
  return m;
}

Mesh turned(Mesh m, const Eigen::Matrix3d& turn) {
  for (Vec3d& p : m.vertices) p = turn * p;
  return m;
}

TEST(Upright, AScanStandsOnItsBaseOrItsOpeningHoweverItIsStored) {
  for (const Vec3d& up :
       {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, -1, 0), Vec3d(0, 0, 1), Vec3d(0, 0, -1)})
    for (const bool has_plate : {true, false})
      for (const double tilt : {0.0, 0.2}) {  // rad: a plaster cast is trimmed by hand
        const Eigen::Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), up).toRotationMatrix() *
                                     Eigen::AngleAxisd(tilt, Vec3d(1, 1, 0).normalized()).toRotationMatrix();
        const auto found = surelyUp(turned(dome(has_plate), turn));
        ASSERT_TRUE(found) << up.transpose() << " " << has_plate << " " << tilt;
        EXPECT_EQ(*found, up) << has_plate << " " << tilt;
      }
}

TEST(Upright, WhatHasNoUnderTellsNothing) {
  EXPECT_FALSE(surelyUp(ball(40, 80, 10)));
  EXPECT_FALSE(surelyUp(box({0, 0, 0}, {2, 4, 6}))) << "a block has as much on the other side";
  EXPECT_FALSE(surelyUp(Mesh{}));
}

}  // namespace
}  // namespace kerf
