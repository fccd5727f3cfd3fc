// A tool from another program: any closed mesh. The part below a given height cuts.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "bench/scenes/fluted_mesh.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/sweep/tool_check.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf::mesh_tool_test {
namespace {

namespace fs = std::filesystem;
constexpr double kPi = std::numbers::pi;

std::string recipe(const std::string& keys) {
  return "format = \"kerf-tool\"\nversion = 1\nid = \"a\"\nname = \"A\"\nkind = \"mesh\"\n" + keys;
}

TEST(MeshTool, ABallInInchesLyingOnItsSideIsABallBur) {
  const TemporaryFolder folder;
  const Mesh ball = ballMesh({1, 2, 3}, 0.7 / 25.4, 64);  // its tip towards +x
  ASSERT_TRUE(writeMesh(folder.path() / "ball.ply", ball));
  const double tip = bounds(ball).max[0];
  const auto tool = readTool(folder.write(
      "a.toml", recipe(fmt::format("mesh = \"ball.ply\"\nmm_per_unit = 25.4\ntip = [{}, 2, 3]\naxis = [-2, 0, 0]\n"
                                   "cut_below = 2\n",
                                   tip))));
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_TRUE(tool->cut->isConvex());
  EXPECT_EQ(tool->body, nullptr);  // all of it cuts
  EXPECT_NEAR(tool->cut->distance(Vec3d(0, 0, 0.7)), -0.7, 0.002);
  EXPECT_NEAR(tool->cut->distance(Vec3d(0, 2, 0.7)), 1.3, 0.002);
  EXPECT_NEAR(plungeVolume(*tool, 2) / (kPi * 0.49 * (2 - 0.7 / 3)), 1, 0.001);  // inscribed: chords of 64 rings
  const auto check = checkTool(*tool, 0.14);
  ASSERT_TRUE(check) << check.error().message();
  EXPECT_LE(std::abs(check->errorPercent()), 1.0) << check->removed_mm3 << " instead of " << check->expected_mm3;
}

TEST(MeshTool, WhatIsNoToolIsRefusedWithWhatToWriteInstead) {
  const TemporaryFolder folder;
  const Mesh ball = ballMesh({0, 0, 0.7}, 0.7, 16);
  ASSERT_TRUE(writeMesh(folder.path() / "ball.ply", ball));
  Mesh open = ball;
  open.triangles.pop_back();
  ASSERT_TRUE(writeMesh(folder.path() / "open.ply", open));
  struct Case {
    const char *keys, *place, *what;
  };
  for (const Case& c : {
           Case{"mesh = \"ball.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0.5]\naxis = [0, 0, 1]\ncut_below = 1\n",
                "line 8, key tip", "tip = [0.0, 0.0, 0.0] and axis = [0.0, 0.0, 1.0]"},
           Case{"mesh = \"open.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 1\n",
                "line 6, key mesh", "kerf bake"},
           Case{"mesh = \"none.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 1\n",
                "line 6, key mesh", "none.ply"},
           Case{"mesh = \"../ball.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 1\n",
                "line 6, key mesh", "folder of this one"},
           Case{"mesh = \"ball.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 0]\ncut_below = 1\n",
                "line 9, key axis", "[0, 0, 1]"},
           Case{"mesh = \"ball.ply\"\nmm_per_unit = 1000\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 1\n",
                "line 7, key mm_per_unit", "1400"},
           Case{"mesh = \"ball.ply\"\nunit = \"mm\"\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 1\n",
                "line 7, key unit", "mm_per_unit = 1"},
       }) {
    const auto tool = readTool(folder.write("a.toml", recipe(c.keys)));
    ASSERT_FALSE(tool) << c.keys;
    EXPECT_NE(tool.error().place.find(c.place), std::string::npos) << tool.error().message();
    EXPECT_NE(tool.error().message().find(c.what), std::string::npos) << tool.error().message();
  }
}

// Two balls, one on the other. The sweep has no slopes to use and samples more densely instead.
TEST(MeshTool, AHeadThatIsNotConvexRemovesWhatItsMeshSays) {
  const TemporaryFolder folder;
  Mesh balls = ballMesh({0, 0, 0.5}, 0.5, 16);
  append(balls, ballMesh({0, 0, 1.75}, 0.75, 16));  // 1.0 to 2.5: they never touch, faces stay apart
  for (std::size_t v = 0; v < balls.vertices.size(); ++v)
    if (v >= balls.vertices.size() / 2) balls.vertices[v][2] += 0.01;
  ASSERT_TRUE(writeMesh(folder.path() / "balls.stl", balls));
  const auto tool = readTool(folder.write(
      "a.toml", recipe("mesh = \"balls.stl\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 3\n")));
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_FALSE(tool->cut->isConvex());
  const auto check = checkTool(*tool, 0.15);
  ASSERT_TRUE(check) << check.error().message();
  EXPECT_LE(std::abs(check->errorPercent()), 1.0) << check->removed_mm3 << " instead of " << check->expected_mm3;
}

TEST(MeshTool, AVertexWithoutATriangleIsNotItsTip) {
  const TemporaryFolder folder;
  Mesh mesh = ballMesh({0, 0, 0.7}, 0.7, 16);
  mesh.vertices.emplace_back(5, 5, -30);
  ASSERT_TRUE(writeMesh(folder.path() / "ball.ply", mesh));
  const std::string keys = "mesh = \"ball.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\n";
  EXPECT_TRUE(readTool(folder.write("a.toml", recipe(keys + "cut_below = 1\n"))));
  // The tip may be 0.02 mm beside the mesh: Kerf rejects a part of no height.
  for (Vec3d& p : mesh.vertices) p[2] += 0.015;
  ASSERT_TRUE(writeMesh(folder.path() / "ball.ply", mesh));
  const auto thin = readTool(folder.write("a.toml", recipe(keys + "cut_below = 0.01\n")));
  ASSERT_FALSE(thin);
  EXPECT_EQ(thin.error().place, "line 10, key cut_below") << thin.error().message();
}

// Its edges are on the cylinder of a bur with shape = "cylinder": turned, it removes as much.
TEST(MeshTool, AFlutedMeshRemovesWhatItsSolidOfRevolutionDoes) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writeMesh(folder.path() / "fluted.stl", flutedMesh([](double) { return 0.8; }, 4)));
  const std::string keys = "mesh = \"fluted.stl\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\n";
  const auto tool = readTool(folder.write("a.toml", recipe(keys + "cut_below = 4\n")));
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_LT(tool->unturned_mm3, 0.8 * tool->turned_mm3);
  const auto check = checkTool(*tool, 0.14);
  ASSERT_TRUE(check) << check.error().message();
  EXPECT_NEAR(check->removed_mm3 / (kPi * 0.64 * check->depth_mm), 1, 0.01);

  const auto half = readTool(folder.write("a.toml", recipe(keys + "cut_below = 2\n")));
  ASSERT_TRUE(half) << half.error().message();
  ASSERT_TRUE(half->body && half->body_turns);
  EXPECT_NEAR(half->body->distance({0, 1, 3}), 0.2, 0.004) << "the edges, not the bottom of a flute";
}

// A rod, and another beside it from 2 mm on.
TEST(MeshTool, APartThatIsNotRoundAboutItsAxisIsRefusedByItsHeight) {
  const TemporaryFolder folder;
  Mesh mesh = tubeMesh(0.7, 0, 0, 5, 16), bar = mesh;
  for (Vec3d& p : bar.vertices) p += Vec3d(6, 0, 2);
  append(mesh, bar);
  ASSERT_TRUE(writeMesh(folder.path() / "bar.stl", mesh));
  const std::string keys = "mesh = \"bar.stl\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\n";
  const auto refused = readTool(folder.write("a.toml", recipe(keys + "cut_below = 4\n")));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().place, "line 10, key cut_below") << refused.error().message();
  EXPECT_NE(refused.error().found.find("at 2 mm"), std::string::npos) << refused.error().message();
  const auto lower = readTool(folder.write("a.toml", recipe(keys + "cut_below = 1.9\n")));
  ASSERT_TRUE(lower) << lower.error().message();
  EXPECT_FALSE(lower->body_turns) << "it stays beside the axis";
}

// The development mesh of a handpiece: its bur is a pencil of ten sides, 2 mm wide, with its point at the origin.
TEST(MeshTool, TheBurOfAHandpieceCutsAndTheHandpieceOnlyCollides) {
  const char* given = std::getenv("KERF_DATA");
  const fs::path data = given ? fs::path(given) : fs::path(kSourceFolder) / ".." / "shared" / "data";
  const fs::path mesh = data / "dental-handpiece-with-bur.obj";
  if (!fs::exists(mesh)) GTEST_SKIP() << mesh << " is not here: set KERF_DATA to try a real handpiece";
  const TemporaryFolder folder;
  fs::copy_file(mesh, folder.path() / "handpiece.obj");
  const auto tool = readTool(folder.write(
      "a.toml", recipe("mesh = \"handpiece.obj\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0.42262, 0, -0.90631]\n"
                       "cut_below = 6\n")));
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_TRUE(tool->cut->isConvex());
  ASSERT_TRUE(tool->body);
  EXPECT_LT(tool->cut->distance(Vec3d(0, 0, 3)), -0.8);
  EXPECT_GT(tool->cut->distance(Vec3d(0, 0, 10)), 3.9);
  EXPECT_LT(tool->body->distance(Vec3d(0, 0, 10)), -0.8);
  EXPECT_GT(tool->body->bounds().max[2], 30);
  EXPECT_FALSE(tool->body_turns);
  // Ten sides, 1 mm to the corners, behind a point 1.236 mm long.
  EXPECT_NEAR(plungeVolume(*tool, 3) / (kPi * (3 - 2.0 / 3 * 1.2361)), 1, 0.005);  // the axis is off by 0.002 mm
  EXPECT_NEAR(tool->unturned_mm3 / tool->turned_mm3, 10 * 0.5 * std::sin(kPi / 5) / kPi, 0.01);
  const auto check = checkTool(*tool, 0.2);
  ASSERT_TRUE(check) << check.error().message();
  EXPECT_LE(std::abs(check->errorPercent()), 1.0) << check->removed_mm3 << " instead of " << check->expected_mm3;
}

}  // namespace
}  // namespace kerf::mesh_tool_test
