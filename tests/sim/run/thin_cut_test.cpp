// Volumes between the nodes of a grid against formulas.
#include "sim/run/sweep/thin_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numbers>

#include "geometry/field/sample_field.h"

namespace kerf::thin_cut_test {
namespace {

constexpr double kVoxel = 0.2;

// A cube from -2 to 2 mm: its faces lie on nodes.
BrickField cube() {
  Box3 box;
  box.add(Vec3d::Constant(-2));
  box.add(Vec3d::Constant(2));
  return sampleDistance([](const Vec3d& p) { return p.cwiseAbs().maxCoeff() - 2; }, box, kVoxel);
}

// A distance in all bricks of a field, as stored for a sweep.
BrickField sweepBeside(const BrickField& phi0, const std::function<double(const Vec3d&)>& distance) {
  BrickField out(kVoxel, static_cast<float>(4 * kVoxel));
  for (std::size_t b = 0; b < phi0.brickCount(); ++b) {
    BrickValues values;
    for (int n = 0; n < kBrickNodes; ++n) {
      const Vec3i node = phi0.brickCoord(b) * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7};
      values[static_cast<std::size_t>(n)] =
          std::clamp(static_cast<float>(distance(phi0.position(node))), -out.background(), out.background());
    }
    out.add(phi0.brickCoord(b), values);
  }
  return out;
}

std::function<double(const Vec3d&)> ball(const Vec3d& center, double radius) {
  return [=](const Vec3d& p) { return (p - center).norm() - radius; };
}

TEST(ThinCut, ALayerOfHalfAVoxelThatNoNodeIsInCounts) {
  const BrickField phi0 = cube(), sweep = sweepBeside(phi0, [](const Vec3d&p) { return 1.9 - p.z(); });
  for (std::size_t b = 0; b < sweep.brickCount(); ++b)
    for (std::size_t n = 0; n < kBrickNodes; ++n) ASSERT_FALSE(sweep.brick(b)[n] < 0 && phi0.brick(b)[n] < 0);
  EXPECT_NEAR(sweptVolume(phi0, sweep), 4 * 4 * 0.1, 1e-6);
  EXPECT_NEAR(thinCutVolume(phi0, sweep), 4 * 4 * 0.1, 0.05);
}

// A layer of a hundredth of a voxel is as exact as a thick one, along each axis.
TEST(ThinCut, AVeryThinLayerHasItsVolume) {
  const BrickField phi0 = cube();
  for (int axis = 0; axis < 3; ++axis)
    for (const double depth : {0.002, 0.01, 0.05}) {
      const BrickField sweep = sweepBeside(phi0, [&](const Vec3d& p) { return 2 - depth - p[axis]; });
      EXPECT_NEAR(sweptVolume(phi0, sweep), 4 * 4 * depth, 1e-5) << axis << ' ' << depth;
    }
}

TEST(ThinCut, AStrokeCountsWhatItAdds) {
  const BrickField phi0 = cube(), thin = sweepBeside(phi0, [](const Vec3d&p) { return 1.9 - p.z(); }),
                   thick = sweepBeside(phi0, [](const Vec3d&p) { return 1.85 - p.z(); });
  const BrickField nothing(kVoxel, thin.background());
  EXPECT_EQ(strokeVolume(phi0, thin, thin), 0);
  EXPECT_EQ(strokeVolume(phi0, thick, thin), 0);
  EXPECT_NEAR(strokeVolume(phi0, nothing, thin), 4 * 4 * 0.1, 0.05);
  EXPECT_NEAR(strokeVolume(phi0, thin, thick), 4 * 4 * 0.05, 0.05);
}

// Linear interpolation cuts chords: 3 % for a ball of five voxels.
TEST(ThinCut, HalfABallHasItsVolume) {
  const BrickField phi0 = cube(), sweep = sweepBeside(phi0, ball({0.03, 0.05, 2}, 1));
  const double half = 2 * std::numbers::pi / 3;
  EXPECT_NEAR(sweptVolume(phi0, sweep), half, 0.04 * half);
  EXPECT_NEAR(thinCutVolume(phi0, sweep), half, 0.02 * half);  // chords cancel
}

TEST(ThinCut, WhatStaysOutsideAndWhatTheExportDropsIsNone) {
  const BrickField phi0 = cube();
  EXPECT_EQ(sweptVolume(phi0, sweepBeside(phi0, ball({0, 0, 2.5}, 0.4))), 0);
  const BrickField crumb = sweepBeside(phi0, ball({0, 0, 2}, 0.1));
  EXPECT_GT(sweptVolume(phi0, crumb), 0);
  EXPECT_EQ(thinCutVolume(phi0, crumb), 0) << "smaller than a voxel";
}

}  // namespace
}  // namespace kerf::thin_cut_test
