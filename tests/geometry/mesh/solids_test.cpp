#include "geometry/mesh/solids.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kerf::solids_test {
namespace {

// Turned inside out for a cavity.
Mesh cube(const Vec3d& center, double side, bool is_cavity = false) {
  Mesh out;
  for (int n = 0; n < 8; ++n)
    out.vertices.push_back(center + 0.5 * side * Vec3d(n & 1 ? 1 : -1, n & 2 ? 1 : -1, n & 4 ? 1 : -1));
  out.triangles = {{4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                   {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}, {0, 2, 1}, {1, 2, 3}};
  if (is_cavity)
    for (Triangle& t : out.triangles) std::swap(t[0], t[1]);
  return out;
}

// A box with a cavity that contains a smaller box, also with a cavity; and a box beside it.
Mesh nested() {
  Mesh out = cube({0, 0, 0}, 10);
  append(out, cube({0, 0, 0}, 6, true));
  append(out, cube({20, 0, 0}, 4));
  append(out, cube({0, 0, 0}, 4));
  append(out, cube({0, 0, 0}, 2, true));
  return out;
}

TEST(Solids, ACavityBelongsToTheSmallestShellAroundIt) {
  const Mesh mesh = nested();
  const Solids solids = solidsOf(mesh);
  EXPECT_EQ(solids.count, 3u);
  const auto of = [&](std::size_t box) { return solids.label[12 * box]; };
  EXPECT_EQ(of(0), of(1));
  EXPECT_EQ(of(3), of(4));
  EXPECT_NE(of(0), of(3));
  EXPECT_NE(of(0), of(2));
}

TEST(Solids, APointIsInTheMaterialItLiesIn) {
  const Mesh mesh = nested();
  const Solids solids = solidsOf(mesh);
  EXPECT_EQ(solidAt(mesh, solids, {4, 0.1, 0.2}), solids.label[0]);
  EXPECT_EQ(solidAt(mesh, solids, {1.5, 0.1, 0.2}), solids.label[36]);
  EXPECT_EQ(solidAt(mesh, solids, {20.3, 1, 1}), solids.label[24]);
  EXPECT_FALSE(solidAt(mesh, solids, {2.5, 0.1, 0.2})) << "in the outer cavity";
  EXPECT_FALSE(solidAt(mesh, solids, {0.1, 0.2, 0.3})) << "in the inner cavity";
  EXPECT_FALSE(solidAt(mesh, solids, {8, 0, 0}));
}

TEST(Solids, ACavityThatNothingIsAroundIsASolidOfItsOwn) {
  Mesh mesh = cube({0, 0, 0}, 2);
  append(mesh, cube({9, 0, 0}, 2, true));
  EXPECT_EQ(solidsOf(mesh).count, 2u);
  EXPECT_EQ(solidsOf(Mesh{}).count, 0u);
}

TEST(Solids, PiecesAreCountedAsPeopleCountThem) {
  const PieceCount count = countPieces(nested());
  EXPECT_EQ(count.pieces, 3u);
  EXPECT_EQ(count.cavities, 2u);
  EXPECT_EQ(count.specks, 0u);
  EXPECT_EQ(describe(count), "3 pieces with 2 cavities");

  Mesh mesh = cube({0, 0, 0}, 10);
  EXPECT_EQ(describe(countPieces(mesh)), "1 piece");
  for (int n = 0; n < 4; ++n) append(mesh, cube({10.0 + 2 * n, 0, 0}, 0.5));
  append(mesh, cube({0, 20, 0}, 2));  // a small piece, no speck
  EXPECT_EQ(describe(countPieces(mesh)), "6 pieces, 4 of them specks (below 1 mm3, 0.5 mm3 together)");
  // Beside an object equally small it is no speck.
  Mesh small = cube({0, 0, 0}, 0.6);
  append(small, cube({2, 0, 0}, 0.5));
  EXPECT_EQ(countPieces(small).specks, 0u);
}

}  // namespace
}  // namespace kerf::solids_test
