#include "sim/hand/merge_motions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tool/sweep.h"
#include "geometry/tool/tool_shape.h"

namespace kerf::merge_motions_test {
namespace {

// A quarter of a circle of radius 5 mm, in motions of equal length.
CutPath arc(std::size_t motions) {
  CutPath path;
  for (std::size_t n = 0; n <= motions; ++n) {
    const double a = 0.5 * M_PI * static_cast<double>(n) / static_cast<double>(motions);
    path.poses.push_back(
        {static_cast<double>(n), {Eigen::Quaterniond::Identity(), {5 * std::cos(a), 5 * std::sin(a), 0}}});
  }
  path.cuts.assign(motions, 1);
  return path;
}

// Largest distance of a place on the path from the merged path, mm. Both without rotation.
double farthest(const CutPath& path, const CutPath& merged) {
  double out = 0;
  for (const PathPose& pose : path.poses) {
    double nearest = 1e9;
    for (std::size_t n = 0; n + 1 < merged.poses.size(); ++n) {
      const Vec3d a = merged.poses[n].T_object_tool.translation, d = merged.poses[n + 1].T_object_tool.translation - a;
      const double s = std::clamp((pose.T_object_tool.translation - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (pose.T_object_tool.translation - a - s * d).norm());
    }
    out = std::max(out, nearest);
  }
  return out;
}

TEST(MergeMotions, AFinePathBecomesOneOfFewMotionsWithinTheTolerance) {
  const CutPath path = arc(20'000);
  const MergedPath merged = mergeShortMotions(path, {0.05, 0.001, 10});
  EXPECT_LT(merged.path.poses.size(), 200u);
  EXPECT_EQ(merged.merged, path.cuts.size());
  EXPECT_EQ(merged.path.cuts.size() + 1, merged.path.poses.size());
  EXPECT_EQ(merged.path.poses.back().t, path.poses.back().t);
  EXPECT_LE(farthest(path, merged.path), 0.001);
  EXPECT_GT(farthest(path, merged.path), 0.0001) << "merged as far as allowed";
}

TEST(MergeMotions, LongMotionsStayAsTheyAre) {
  const CutPath path = arc(50);  // 0.16 mm each
  const MergedPath merged = mergeShortMotions(path, {0.05, 0.001, 10});
  EXPECT_EQ(merged.merged, 0u);
  EXPECT_EQ(merged.path.poses.size(), path.poses.size());
}

TEST(MergeMotions, NeitherCornersNorTurnsBackNorMovesInAirAreLost) {
  CutPath path;  // there and back on a line, every 10 um; a corner at 0.5
  const auto add = [&](double x, double y) {
    if (!path.poses.empty()) path.cuts.push_back(1);
    path.poses.push_back({static_cast<double>(path.poses.size()), {Eigen::Quaterniond::Identity(), {x, y, 0}}});
  };
  for (int n = 0; n <= 50; ++n) add(0.01 * n, 0);
  for (int n = 1; n <= 50; ++n) add(0.5, 0.01 * n);
  for (int n = 49; n >= 0; --n) add(0.5, 0.01 * n);
  path.cuts[120] = 0;
  const MergedPath merged = mergeShortMotions(path, {0.05, 0.001, 0});
  EXPECT_LT(merged.path.poses.size(), 40u);
  EXPECT_LE(farthest(path, merged.path), 0.001);
  std::size_t in_air = 0;
  for (std::size_t n = 0; n < merged.path.cuts.size(); ++n) {
    if (merged.path.cuts[n]) continue;
    ++in_air;
    EXPECT_NEAR(merged.path.poses[n].T_object_tool.translation.y(), path.poses[120].T_object_tool.translation.y(), 0);
  }
  EXPECT_EQ(in_air, 1u);
}

// A rotating tool: its far end counts, not its tip.
TEST(MergeMotions, TheFarEndOfAToolStaysWithinTheTolerance) {
  CutPath path;
  for (int n = 0; n <= 1000; ++n) {
    // The tip is fixed and the tool nods at varying speed: the share of the turn differs from the share of the poses.
    const double a = 0.4 * std::sin(0.004 * n);
    path.poses.push_back({0.001 * n, {Eigen::Quaterniond(Eigen::AngleAxisd(a, Vec3d::UnitX())), Vec3d::Zero()}});
  }
  path.cuts.assign(1000, 1);
  for (std::size_t n = 300; n < 400; ++n)  // and wobbles to the side
    path.poses[n].T_object_tool.rotation =
        path.poses[n].T_object_tool.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(n % 2 ? 2e-4 : 0, Vec3d::UnitY()));
  const MergedPath merged = mergeShortMotions(path, {0.05, 0.001, 20});
  EXPECT_GT(merged.merged, 700u);
  EXPECT_GT(merged.path.poses.size(), 100u) << "0.2 mrad at 20 mm are 4 um: more than the tolerance";
  EXPECT_LT(merged.path.poses.size(), 200u);
}

}  // namespace
}  // namespace kerf::merge_motions_test
