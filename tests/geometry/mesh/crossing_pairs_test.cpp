#include "geometry/mesh/crossing_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace kerf::crossing_pairs_test {
namespace {

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

Mesh twoTriangles(const std::vector<Vec3d>& points, const Triangle& a, const Triangle& b) {
  Mesh m;
  m.vertices = points;
  m.triangles = {a, b};
  return m;
}

TEST(CrossingPairs, CrossingAndTouchingTrianglesAreFoundNeighboursAreNot) {
  const std::vector<Vec3d> p = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0},   {.5, .5, -1}, {.5, .5, 1},
                                {3, 3, 1}, {2, 2, 0}, {.5, .5, 0}, {5, 5, 5}};
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {3, 4, 5})), (Pairs{{0, 1}}));  // pierces
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {1, 6, 2})), Pairs{});  // common edge, coplanar, opposite sides
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {1, 2, 7})),
            (Pairs{{0, 1}}));                                                // common edge, folded onto each other
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {1, 4, 8})), Pairs{});  // common vertex
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {0, 3, 4})), (Pairs{{0, 1}}));  // common vertex, pierces
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {7, 4, 8})), (Pairs{{0, 1}}));  // touches in a point
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {0, 2, 1})), (Pairs{{0, 1}}));  // same corners
}

TEST(CrossingPairs, TriangleWithoutAreaIsReported) {
  const std::vector<Vec3d> p = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0, 0}, {9, 9, 9}};
  // 3 lies in the middle of edge 0-1 of the other triangle.
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {1, 0, 3})), (Pairs{{0, 1}, {1, 1}}));
  EXPECT_EQ(crossingPairs(twoTriangles(p, {0, 1, 2}, {4, 4, 4})), (Pairs{{1, 1}}));
}

// Corners on a coarse grid: many triangles touch, repeat each other or have no area.
Mesh heapOfTriangles(std::mt19937& random) {
  Mesh m;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 3; ++z) m.vertices.emplace_back(x, y, z);
  std::uniform_int_distribution<std::uint32_t> vertex(0, 26);
  for (int t = 0; t < 60; ++t) m.triangles.push_back({vertex(random), vertex(random), vertex(random)});
  return m;
}

TEST(CrossingPairs, ThoseOfChosenTrianglesAreThoseOfAllThatHoldOne) {
  std::mt19937 random(20261128);
  for (int heap = 0; heap < 40; ++heap) {
    const Mesh m = heapOfTriangles(random);
    std::vector<char> chosen(m.triangles.size());
    for (char& c : chosen) c = random() % 8 == 0;
    Pairs expected = crossingPairs(m);
    std::erase_if(expected, [&](const auto& pair) { return !chosen[pair[0]] && !chosen[pair[1]]; });
    EXPECT_EQ(crossingPairsOf(m, chosen), expected);
    EXPECT_EQ(crossingPairsOf(m, std::vector<char>(m.triangles.size(), 1)), crossingPairs(m));
    EXPECT_EQ(crossingPairsOf(m, std::vector<char>(m.triangles.size(), 0)), Pairs{});
  }
}

}  // namespace
}  // namespace kerf::crossing_pairs_test
