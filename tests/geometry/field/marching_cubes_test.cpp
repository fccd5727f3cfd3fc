#include "geometry/field/marching_cubes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/geometry/sampled_field.h"

namespace kerf::marching_cubes_test {
namespace {

TEST(MarchingCubes, BallVolumeIsWithinAFewHundredthsOfAPercentFromFiveVoxelsOn) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  for (const auto& [voxels, tolerance] : {std::pair{5.0, 0.0008}, {10.0, 0.0003}, {20.0, 0.0001}}) {
    const double r = 1.0, h = r / voxels;
    for (int round = 0; round < 5; ++round) {
      const Vec3d c = h * Vec3d(shift(random), shift(random), shift(random));
      Box3 box;
      box.add(c);
      box.grow(r);
      const Mesh m = marchingCubes(sampled(h, box, [&](const Vec3d& p) { return (p - c).norm() - r; }));
      expectClosedManifold(m);
      const double exact = 4.0 / 3.0 * std::numbers::pi * r * r * r;
      EXPECT_NEAR(signedVolume(m) / exact, 1.0, tolerance) << "radius " << voxels << " voxels";
      for (const Vec3d& p : m.vertices) EXPECT_LT(std::abs((p - c).norm() - r), 0.07 * h);
    }
  }
}

TEST(MarchingCubes, PlateOfFourVoxelsKeepsItsVolumeAndItsFlatSides) {
  const Vec3d half(0.2, 1.0, 1.0);
  const double h = 0.1;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()));
  Box3 box;
  box.add(Vec3d::Zero());
  box.grow(1.5);
  const auto plate = [&](const Vec3d& p) {
    const Vec3d d = (turn * p).cwiseAbs() - half;
    return d.cwiseMax(0.0).norm() + std::min(0.0, d.maxCoeff());
  };
  const Mesh m = marchingCubes(sampled(h, box, plate));
  expectClosedManifold(m);
  EXPECT_NEAR(signedVolume(m) / (8 * half.prod()), 1.0, 0.005);
  for (const Vec3d& p : m.vertices) {
    const Vec3d q = (turn * p).cwiseAbs();
    if (q[1] < 0.85 && q[2] < 0.85) {  // on a flat side
      EXPECT_NEAR(q[0], half[0], 0.03 * h);
    }
  }
}

TEST(MarchingCubes, NoiseGivesAClosedManifoldWhateverTheSigns) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> value(-0.1f, 0.1f);
  BrickField field(0.1, 0.4f);
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        BrickValues& v = field.brick(field.touch({x, y, z}));
        if (x == 0 && y == 0 && z == 0)
          for (float& f : v) f = value(random);
      }
  const Mesh m = marchingCubes(field);
  EXPECT_GT(m.triangles.size(), 500u);
  expectClosedManifold(m);
}

TEST(MarchingCubes, SurfaceBesideAMissingBrickIsClosed) {
  BrickField field(0.1, 0.4f);
  BrickValues& v = field.brick(field.touch({0, 0, 0}));
  v.fill(-0.4f);  // a solid brick beside an unstored one
  const Mesh m = marchingCubes(field);
  expectClosedManifold(m);
  EXPECT_GT(signedVolume(m), 0.5);
}

TEST(BrickField, MissingBricksAreConstantAndHashIgnoresOrder) {
  BrickField a(0.1, 0.3f), b(0.1, 0.3f);
  a.markInterior({5, 5, 5});
  EXPECT_EQ(a.at({40, 41, 42}), -0.3f);
  EXPECT_EQ(a.at({-1, -1, -1}), 0.3f);
  EXPECT_EQ(a.brick(a.touch({5, 5, 5}))[0], -0.3f);
  BrickField c(0.1, 0.3f);
  b.touch({0, 0, 0});
  b.touch({-4, 2, 1});
  c.touch({-4, 2, 1});
  c.touch({0, 0, 0});
  EXPECT_EQ(b.stateHash(), c.stateHash());
  c.brick(0)[17] = 0.25f;
  EXPECT_NE(b.stateHash(), c.stateHash());
}

}  // namespace
}  // namespace kerf::marching_cubes_test
