#include "geometry/mesh/mesh_check.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace kerf::mesh_check_test {
namespace {

// Outward cube of side 2 at `at`; its 12 triangles all touch welded corners.
Mesh cube(const Vec3d& at, double side = 2) {
  Mesh m;
  for (int i = 0; i < 8; ++i) m.vertices.push_back(at + side * Vec3d(i & 1, i >> 1 & 1, i >> 2 & 1));
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

Mesh flipped(Mesh m) {
  for (Triangle& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}

Mesh joined(Mesh a, const Mesh& b) {
  append(a, b);
  return a;
}

TEST(MeshCheck, CubeIsReadyWhereverItStands) {
  for (const Vec3d& at : {Vec3d(0, 0, 0), Vec3d(200, -300, 150)}) {
    const MeshReport r = checkMesh(cube(at));
    EXPECT_TRUE(r.print_ready) << describe(r);
    EXPECT_TRUE(r.isClosed());
    EXPECT_DOUBLE_EQ(r.volume, 8);
    EXPECT_DOUBLE_EQ(r.area, 24);
    EXPECT_EQ(r.pieces, 1u);
  }
}

TEST(MeshCheck, UnweldedSoupIsJudgedWelded) {
  const Mesh indexed = cube({0, 0, 0});
  Mesh soup;
  for (const Triangle& t : indexed.triangles) {
    const auto base = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t v : t) soup.vertices.push_back(indexed.vertices[v]);
    soup.triangles.push_back({base, base + 1, base + 2});
  }
  const MeshReport r = checkMesh(soup);
  EXPECT_TRUE(r.print_ready);
  EXPECT_EQ(r.duplicate_vertices, 28u);
}

TEST(MeshCheck, OpenSurfaceListsItsLoops) {
  Mesh m = cube({0, 0, 0});
  m.triangles.erase(m.triangles.begin(), m.triangles.begin() + 2);  // the bottom
  m.triangles.pop_back();                                           // and half of a side
  const MeshReport r = checkMesh(m);
  EXPECT_FALSE(r.print_ready);
  EXPECT_EQ(r.boundary_edges, 7u);
  ASSERT_EQ(r.boundary_loops.size(), 1u) << "they touch in a corner, which joins them";
  EXPECT_NEAR(r.boundary_loops[0].length, 8 + 4 + std::sqrt(8.0), 1e-12);
}

TEST(MeshCheck, FindsWhatIsWrong) {
  const Mesh good = cube({0, 0, 0});
  Mesh m = good;
  std::swap(m.triangles[0][1], m.triangles[0][2]);
  EXPECT_EQ(checkMesh(m).flipped_edges, 3u);
  EXPECT_FALSE(checkMesh(m).print_ready);

  m = good;
  m.triangles.push_back(m.triangles[3]);
  MeshReport r = checkMesh(m);
  EXPECT_EQ(r.duplicate_triangles, 1u);
  EXPECT_EQ(r.non_manifold_edges, 3u);
  EXPECT_FALSE(r.print_ready);

  r = checkMesh(joined(good, cube({2, 2, 0})));  // two cubes along one edge
  EXPECT_EQ(r.non_manifold_edges, 1u);
  EXPECT_FALSE(r.print_ready);

  r = checkMesh(joined(good, cube({2, 2, 2})));  // two cubes in one corner
  EXPECT_EQ(r.non_manifold_vertices, 1u);
  EXPECT_EQ(r.pieces, 2u);
  EXPECT_FALSE(r.print_ready);

  r = checkMesh(joined(good, cube({1, 1, 1})));
  EXPECT_GT(r.self_intersections, 0u);
  EXPECT_FALSE(r.print_ready);
  EXPECT_EQ(checkMesh(joined(good, cube({1, 1, 1})), {.max_self_intersections = 1}).self_intersections, 1u);

  EXPECT_FALSE(checkMesh(good, {.self_intersections = false}).print_ready) << "never ready without looking";
  EXPECT_FALSE(checkMesh(Mesh{}).print_ready);
}

TEST(MeshCheck, CavityIsFineAndInsideOutIsNot) {
  const Mesh hollow = joined(cube({0, 0, 0}, 4), flipped(cube({1, 1, 1})));
  MeshReport r = checkMesh(hollow);
  EXPECT_TRUE(r.print_ready) << describe(r);
  EXPECT_EQ(r.inward_pieces, 0u);
  EXPECT_DOUBLE_EQ(r.volume, 64 - 8);
  EXPECT_EQ(r.pieces, 1u) << "as export counts: the wall of a cavity is no piece";
  EXPECT_EQ(r.cavities, 1u);
  EXPECT_EQ(r.specks, 0u);
  r = checkMesh(joined(cube({0, 0, 0}, 4), flipped(cube({9, 1, 1}))));
  EXPECT_EQ(r.inward_pieces, 1u);
  EXPECT_FALSE(r.print_ready);
  EXPECT_EQ(checkMesh(flipped(cube({0, 0, 0}))).inward_pieces, 1u);
}

// Two vertices 1e-9 mm apart are one vertex in the file: a mesh can be sound in double and broken in print.
TEST(MeshCheck, JudgesTheMeshAsRoundedToFloat32) {
  Mesh m = cube({100, 0, 0});
  // Split the corner 0 by a sliver: 0 and the new vertex 8 differ only in double.
  m.vertices.push_back(m.vertices[0] + Vec3d(1e-9, 0, 0));
  m.triangles[4] = {8, 1, 4};
  m.triangles[0] = {8, 2, 1};
  m.triangles.push_back({0, 8, 4});
  m.triangles.push_back({0, 2, 8});
  const MeshReport r = checkMesh(m);
  EXPECT_EQ(r.duplicate_vertices, 1u);
  EXPECT_EQ(r.degenerate_triangles, 2u);
  EXPECT_FALSE(r.print_ready);
}

TEST(MeshCheck, NeedleOnALineIsDegenerate) {
  Mesh m = cube({0, 0, 0});
  m.vertices.push_back({1, 0, 0});  // the middle of edge 0-1
  m.triangles.push_back({0, 8, 1});
  EXPECT_EQ(checkMesh(m).degenerate_triangles, 1u);
}

TEST(MeshCheck, JsonAndTextCarryTheVerdict) {
  const auto json = nlohmann::json::parse(toJson(checkMesh(cube({0, 0, 0}))));
  EXPECT_EQ(json["print_ready"], true);
  EXPECT_EQ(json["volume_mm3"], 8.0);
  EXPECT_EQ(json["box_mm"]["max"][2], 2.0);
  const auto empty = nlohmann::json::parse(toJson(checkMesh(Mesh{})));
  EXPECT_EQ(empty["print_ready"], false);
  EXPECT_TRUE(empty["box_mm"].is_null());
  Mesh open = cube({0, 0, 0});
  open.triangles.pop_back();
  EXPECT_NE(describe(checkMesh(open)).find("3 boundary edges along 1 loop"), std::string::npos)
      << describe(checkMesh(open));
}

TEST(MeshCheck, WhatNoPrinterTakesIsNotReady) {
  EXPECT_TRUE(checkMesh(cube({0, 0, 0}, 1900)).print_ready);
  const MeshReport large = checkMesh(cube({0, 0, 0}, 2100));
  EXPECT_FALSE(large.print_ready);
  ASSERT_EQ(large.reasons.size(), 1u);
  EXPECT_NE(large.reasons[0].find("2100 mm long"), std::string::npos) << large.reasons[0];

  EXPECT_TRUE(checkMesh(cube({0, 0, 0}, 0.2)).print_ready);
  const MeshReport tiny = checkMesh(cube({0, 0, 0}, 1e-20));
  EXPECT_FALSE(tiny.print_ready);
  ASSERT_FALSE(tiny.reasons.empty());
  EXPECT_NE(tiny.reasons[0].find("1e-20 mm long, less than any printer makes"), std::string::npos) << tiny.reasons[0];
}

}  // namespace
}  // namespace kerf::mesh_check_test
