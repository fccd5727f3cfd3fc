#include "preprocess/close/pinholes.h"

#include <gtest/gtest.h>

#include "preprocess/close/close.h"
#include "preprocess/close/edges.h"

namespace kerf::pinholes_test {
namespace {

using internal::ShortLoop;

// Present and missing cells of a square sheet, `cell` mm wide, between z = 0 and z = height: a closed solid.
Mesh plate(int side, const std::vector<std::array<int, 2>>& missing, double cell, double height) {
  Mesh m;
  const auto vertex = [&](int i, int j, int k) {
    return static_cast<std::uint32_t>((k * (side + 1) + j) * (side + 1) + i);
  };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= side; ++j)
      for (int i = 0; i <= side; ++i) m.vertices.push_back({i * cell, j * cell, k * height});
  const auto isThere = [&](int i, int j) {
    if (i < 0 || j < 0 || i >= side || j >= side) return false;
    return std::find(missing.begin(), missing.end(), std::array<int, 2>{i, j}) == missing.end();
  };
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    m.triangles.push_back({a, b, c});
    m.triangles.push_back({a, c, d});
  };

  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      if (!isThere(i, j)) continue;
      quad(vertex(i, j, 1), vertex(i + 1, j, 1), vertex(i + 1, j + 1, 1), vertex(i, j + 1, 1));
      quad(vertex(i, j, 0), vertex(i, j + 1, 0), vertex(i + 1, j + 1, 0), vertex(i + 1, j, 0));
      if (!isThere(i - 1, j)) quad(vertex(i, j, 0), vertex(i, j, 1), vertex(i, j + 1, 1), vertex(i, j + 1, 0));
      if (!isThere(i + 1, j))
        quad(vertex(i + 1, j, 0), vertex(i + 1, j + 1, 0), vertex(i + 1, j + 1, 1), vertex(i + 1, j, 1));
      if (!isThere(i, j - 1)) quad(vertex(i, j, 0), vertex(i + 1, j, 0), vertex(i + 1, j, 1), vertex(i, j, 1));
      if (!isThere(i, j + 1))
        quad(vertex(i, j + 1, 0), vertex(i, j + 1, 1), vertex(i + 1, j + 1, 1), vertex(i + 1, j + 1, 0));
    }
  return subset(m, std::vector<char>(m.triangles.size(), 1));
}

long eulerOf(const Mesh& m) {
  long edges = 0;
  internal::forEachEdge(internal::edgeUses(m.triangles), [&](const auto&) { ++edges; });
  return static_cast<long>(m.vertices.size()) - edges + static_cast<long>(m.triangles.size());
}

// The solid united with the plugs of a loop, from the effective side; otherwise the lowest Euler characteristic.
long eulerWithPlug(const Mesh& solid, const ShortLoop& loop) {
  long best = -1000;
  for (const bool is_left : {true, false}) {
    const Mesh plug = internal::plugOf(solid, loop, is_left);
    EXPECT_GT(signedVolume(plug), 0);
    const auto united = closeMeshes(std::array<Mesh, 2>{solid, plug});
    if (!united) continue;
    EXPECT_EQ(edgeConnectedPieces(united->mesh).count, 1u);
    best = std::max(best, eulerOf(united->mesh));
  }
  return best;
}

TEST(Pinholes, AHoleThroughAPlateIsFoundByTheShortestWayAroundIt) {
  const Mesh solid = plate(9, {{4, 4}}, 0.25, 1);
  ASSERT_EQ(eulerOf(solid), 0);
  const auto loops = internal::shortLoops(solid, 4, {});
  ASSERT_FALSE(loops.empty());
  EXPECT_NEAR(loops[0].length, 1, 0.01) << "around a square of 0.25 mm";
  EXPECT_TRUE(loops[0].is_tunnel);
  EXPECT_LT((loops[0].middle.head<2>() - Eigen::Vector2d(1.125, 1.125)).norm(), 0.05);
  EXPECT_EQ(eulerWithPlug(solid, loops[0]), 2);
}

TEST(Pinholes, EveryOneOfSeveralHolesIsFoundAndPlugged) {
  const Mesh solid = plate(13, {{2, 2}, {2, 9}, {9, 5}}, 0.25, 1);
  ASSERT_EQ(eulerOf(solid), -4);
  const auto loops = internal::shortLoops(solid, 1.5, {});
  std::array<bool, 3> found{};
  for (const ShortLoop& loop : loops) {
    EXPECT_EQ(eulerWithPlug(solid, loop), -2);
    for (std::size_t h = 0; h < 3; ++h) {
      const Eigen::Vector2d hole = 0.25 * std::array<Eigen::Vector2d, 3>{{{2.5, 2.5}, {2.5, 9.5}, {9.5, 5.5}}}[h];
      if ((loop.middle.head<2>() - hole).norm() < 0.1) found[h] = true;
    }
  }
  EXPECT_TRUE(found[0] && found[1] && found[2]);
}

TEST(Pinholes, APlateWithoutHolesAndHolesLongerAroundThanAskedForGiveNone) {
  EXPECT_TRUE(internal::shortLoops(plate(9, {}, 0.25, 1), 4, {}).empty());
  EXPECT_TRUE(internal::shortLoops(plate(9, {{4, 4}}, 0.25, 1), 0.9, {}).empty());
}

// A ring 4 mm across, with one cell of 0.25 x 0.1 mm on its left: the shortest path that bounds nothing is there.
TEST(Pinholes, AThreadOfMaterialIsFoundAndCut) {
  std::vector<std::array<int, 2>> missing;
  for (int j = 3; j < 13; ++j)
    for (int i = 0; i < 13; ++i)
      if (i != 1) missing.push_back({i, j});
  const Mesh solid = plate(16, missing, 0.25, 0.1);
  ASSERT_EQ(eulerOf(solid), 0);
  const auto loops = internal::shortLoops(solid, 1, {});
  ASSERT_FALSE(loops.empty());
  EXPECT_FALSE(loops[0].is_tunnel);
  EXPECT_NEAR(loops[0].length, 0.7, 0.01);
  const Mesh plug = internal::plugOf(solid, loops[0], true);
  EXPECT_LT(signedVolume(plug), 0) << "what is taken away faces inwards";
}

}  // namespace
}  // namespace kerf::pinholes_test
