// The tree over the motions of a path against a test of each motion.
#include "sim/run/sweep/swept_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/tool/sweep.h"
#include "geometry/tool/tool_file.h"

namespace kerf::swept_path_test {
namespace {

// A winding path on which the tool tilts and turns; every tenth motion is in air.
CutPath windingPath(std::size_t motions) {
  CutPath path;
  for (std::size_t n = 0; n <= motions; ++n) {
    const double s = static_cast<double>(n) / static_cast<double>(motions);
    const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.6 * std::sin(9 * s), Vec3d(1, 0.5, 0).normalized()));
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(2 * s, Vec3d::UnitZ()));
    path.poses.push_back({s, {(tilt * turn).normalized(), Vec3d(4 * std::cos(7 * s), 3 * std::sin(5 * s), -s)}});
    if (n < motions) path.cuts.push_back(n % 10 != 9);
  }
  return path;
}

TEST(SweptPath, IsAsFarAsTheNearestOfAllMotions) {
  constexpr double kFar = 0.8, kTolerance = 1e-6;
  for (const char* id : {"round-014", "856-016", "disc-22"}) {
    const auto file = findToolFile(id, defaultToolFolders());
    ASSERT_TRUE(file);
    const auto tool = readTool(*file);
    ASSERT_TRUE(tool) << tool.error().message();
    const CutPath path = windingPath(300);
    const SweptPath swept(*tool->cut, path);
    EXPECT_EQ(swept.motionCount(), 270u);

    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-6, 6);
    int near = 0;
    for (int n = 0; n < 300; ++n) {
      const Vec3d x(place(random), place(random), 0.4 * place(random));
      double expected = kFar;
      for (std::size_t m = 0; m + 1 < path.poses.size(); ++m)
        if (path.cuts[m])
          expected =
              std::min(expected, SweptTool(*tool->cut, path.poses[m].T_object_tool, path.poses[m + 1].T_object_tool)
                                     .distance(x, expected, kTolerance, -kFar));
      const double found = swept.nearest(x, kFar, kTolerance).distance_mm;
      if (expected > -kFar)
        EXPECT_NEAR(found, expected, 2 * kTolerance) << id << " at " << x.transpose();
      else
        EXPECT_LE(found, -kFar) << id << " at " << x.transpose();
      near += expected < kFar;
    }
    EXPECT_GT(near, 30) << id;
  }
}

TEST(SweptPath, AsksFewOfManyMotions) {
  const auto file = findToolFile("round-014", defaultToolFolders());
  ASSERT_TRUE(file);
  const auto tool = readTool(*file);
  ASSERT_TRUE(tool);
  const CutPath path = windingPath(20'000);
  const SweptPath swept(*tool->cut, path);
  // Points on the wall of the cut, as queried by exports: at the side of the ball.
  std::size_t asked = 0;
  constexpr std::size_t kPoints = 200;
  for (std::size_t n = 0; n < kPoints; ++n) {
    const Rigid3& pose = path.poses[100 * n].T_object_tool;
    asked += swept.nearest(pose * Vec3d(0.7, 0, 0.7), 0.4, 1e-6).motions;
  }
  EXPECT_LT(asked / kPoints, 400u) << "of 18 000";
}

TEST(SweptPath, NothingIsFarFromNothing) {
  const auto file = findToolFile("round-014", defaultToolFolders());
  const auto tool = readTool(*file);
  CutPath path = windingPath(5);
  std::fill(path.cuts.begin(), path.cuts.end(), char{0});
  EXPECT_EQ(SweptPath(*tool->cut, path).nearest(Vec3d::Zero(), 0.4, 1e-6).distance_mm, 0.4);
}

}  // namespace
}  // namespace kerf::swept_path_test
