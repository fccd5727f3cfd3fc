#include "geometry/tool/tool_ways.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/geometry/turned_rod.h"

namespace kerf::tool_ways_test {
namespace {

TEST(ToolWays, TheThinnestEndIsTakenForTheTip) {
  const std::vector<ToolWay> ways = toolWays(handpiece());
  ASSERT_GE(ways.size(), 8u);
  EXPECT_EQ(ways[0].name, "-y") << "an axis of the file goes before the length, which is the same way";
  EXPECT_NEAR((ways[0].tip - Vec3d(3, -2, 5)).norm(), 0, 1e-6);
  EXPECT_NEAR(ways[0].tip_width_mm, 1.4, 0.02);
  EXPECT_NEAR(ways[0].cut_below_mm, kBurLength, 0.26) << "no farther than the head";
  EXPECT_GT(ways[2].tip_width_mm, 5);
}

// A contra-angle: its bur follows no axis of the file, nor its length.
TEST(ToolWays, AThinEndIsFoundWhicheverWayItPoints) {
  const Vec3d axis = Vec3d(0.42, 0.1, -0.9).normalized();
  Mesh mesh = turned({{0, 0.05}, {1.2, 0.9}, {4, 0.9}, {4.5, 4}, {12, 4}}, {1, 2, 3}, axis);
  const Mesh handle = turned({{0, 5}, {60, 7}}, Vec3d(1, 2, 3) + 10 * axis, Vec3d::UnitX());
  append(mesh, handle);
  const std::vector<ToolWay> ways = toolWays(mesh);
  EXPECT_EQ(ways[0].name, "thin-end");
  EXPECT_GT(ways[0].axis.dot(axis), std::cos(0.03));
  EXPECT_NEAR(ways[0].tip_width_mm, 1.8, 0.15);
  EXPECT_NEAR((ways[0].tip - Vec3d(1, 2, 3)).norm(), 0, 0.15);
}

TEST(ToolWays, TheSpreadOfABoxIsThatOfItsFaces) {
  Mesh rod = turned({{0, 0.5}, {12, 0.5}}, {1, 2, 3}, Vec3d::UnitX());
  const SurfaceSpread spread = spreadOf(rod);
  EXPECT_NEAR((spread.middle - Vec3d(7, 2, 3)).norm(), 0, 1e-9);
  EXPECT_NEAR(std::abs(spread.longest[0]), 1, 1e-9);
  // Side of 12 mm and two lids of area pi/4, at +-6 mm: the mean square of x over the surface of the 16-gon.
  const double side = 16 * std::sin(std::numbers::pi / 16) * 12, lids = 16 * 0.25 * std::sin(std::numbers::pi / 8);
  EXPECT_NEAR(spread.extents[2] * spread.extents[2], (side * 12 + lids * 36) / (side + lids), 1e-9);
  EXPECT_TRUE(spread.isSlender());
}

}  // namespace
}  // namespace kerf::tool_ways_test
