#include "ui/app/view/mesh_chunks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "tests/geometry/ball_mesh.h"
#include "ui/app/import/import_mesh.h"

namespace kerf::mesh_chunks_test {
namespace {

TEST(MeshChunks, HoldEveryTriangleOnceAndKeepItsColour) {
  Mesh bur = ballMesh({0, 0, 0.5}, 0.5, 16);
  bur.vertex_colors.assign(bur.vertices.size(), {200, 10, 10, 255});
  Mesh joined;
  for (const ColouredChunk& made : chunksOf(bur, 0.7)) {
    ASSERT_EQ(made.colours.size(), made.chunk.vertices.size());
    for (const Vec3f& n : made.chunk.normals) EXPECT_NEAR(n.norm(), 1, 1e-5);
    for (const Rgba8& c : made.colours) EXPECT_EQ(c[0], 200);
    Mesh part;
    for (const Vec3f& p : made.chunk.vertices) part.vertices.push_back(p.cast<double>());
    for (const auto& t : made.chunk.triangles) part.triangles.push_back({t[0], t[1], t[2]});
    append(joined, part);
  }
  EXPECT_EQ(joined.triangles.size(), bur.triangles.size());
  EXPECT_NEAR(signedVolume(joined) / signedVolume(bur), 1, 1e-5);
  EXPECT_TRUE(chunksOf({}).empty());
}

TEST(MeshChunks, ACellWithTooManyVerticesIsDivided) {
  Mesh strip;
  for (std::uint32_t n = 0; n < 30000; ++n) {
    const double x = 1e-4 * n;
    const auto first = static_cast<std::uint32_t>(strip.vertices.size());
    for (const Vec3d& p : {Vec3d(x, 0, 0), Vec3d(x + 1e-4, 0, 0), Vec3d(x, 1, 0)}) strip.vertices.push_back(p);
    strip.triangles.push_back({first, first + 1, first + 2});
  }
  std::size_t triangles = 0;
  for (const ColouredChunk& made : chunksOf(strip, 10)) {
    EXPECT_LE(made.chunk.vertices.size(), 65536u);
    triangles += made.chunk.triangles.size();
  }
  EXPECT_EQ(triangles, 30000u);
}

// Triangles at one spot, or too far away for cell numbers.
TEST(MeshChunks, AHeapIsDividedByCountAndEveryPartHasABrickOfItsOwn) {
  for (const double place : {0.0, 3.0, -1e15, 1e15}) {
    Mesh heap;
    heap.vertices = {Vec3d::Constant(place), Vec3d(place, place, 1), Vec3d(0, 1, place)};
    heap.triangles.assign(50000, {0, 0, 0});
    heap.triangles.push_back({0, 1, 2});
    std::set<std::array<int, 3>> bricks;
    std::size_t triangles = 0;
    const std::vector<ColouredChunk> chunks = chunksOf(heap);
    for (const ColouredChunk& made : chunks) {
      EXPECT_LE(made.chunk.triangles.size(), 65536u / 3);
      triangles += made.chunk.triangles.size();
      bricks.insert({made.chunk.brick[0], made.chunk.brick[1], made.chunk.brick[2]});
    }
    EXPECT_EQ(triangles, 50001u) << place;
    EXPECT_EQ(bricks.size(), chunks.size()) << "the renderer knows a chunk by its brick";
    EXPECT_LE(chunks.size(), 4u);
  }
}

// ---- Imported meshes

bool hasColour(const Mesh& mesh, std::size_t from, std::size_t to, const Rgba8& colour) {
  return std::all_of(mesh.face_colors.begin() + static_cast<std::ptrdiff_t>(from),
                     mesh.face_colors.begin() + static_cast<std::ptrdiff_t>(to),
                     [&](const Rgba8& c) { return c == colour; });
}

TEST(ImportMesh, OfOneClosedPartIsThatPartInMm) {
  const auto inch = std::make_shared<const Mesh>(ballMesh({1, 0, 0}, 1, 8));
  const Mesh drawn = meshOf({.parts = {{.mesh = inch, .scale_to_mm = 25.4}}, .box = {}, .of = ""});
  EXPECT_EQ(drawn.triangles, inch->triangles);
  EXPECT_FALSE(drawn.hasFaceColors() || drawn.hasVertexColors());
  EXPECT_NEAR(bounds(drawn).max[0], 2 * 25.4, 1e-4);
}

TEST(ImportMesh, AnOpenPartShowsAnInsideOfAnotherColourFromBehind) {
  Mesh open = ballMesh(Vec3d::Zero(), 1, 8);
  open.triangles.resize(open.triangles.size() / 2);
  open.vertex_colors.assign(open.vertices.size(), {200, 10, 10, 255});
  const std::size_t count = open.triangles.size();
  const Mesh drawn =
      meshOf({.parts = {{.mesh = std::make_shared<const Mesh>(open), .is_open = true}}, .box = {}, .of = ""});

  ASSERT_EQ(drawn.triangles.size(), 2 * count);
  EXPECT_TRUE(hasColour(drawn, 0, count, {200, 10, 10, 255}));
  EXPECT_TRUE(hasColour(drawn, count, 2 * count, drawn.face_colors.back()));
  EXPECT_NE(drawn.face_colors.back(), drawn.face_colors.front());
  for (std::size_t t = 0; t < count; ++t)
    EXPECT_LT((doubleAreaVector(drawn, t) + doubleAreaVector(drawn, t + count)).norm(), 1e-9);
}

TEST(ImportMesh, OfSeveralWhatStandsBesideIsPaler) {
  Mesh red = ballMesh(Vec3d::Zero(), 1, 8);
  red.face_colors.assign(red.triangles.size(), {200, 10, 10, 255});
  const auto mesh = std::make_shared<const Mesh>(red);
  const std::size_t count = red.triangles.size();
  const Mesh drawn = meshOf({.parts = {{.mesh = mesh, .is_beside = true}, {.mesh = mesh}}, .box = {}, .of = ""});

  ASSERT_EQ(drawn.triangles.size(), 2 * count);
  EXPECT_TRUE(hasColour(drawn, count, 2 * count, {200, 10, 10, 255}));
  EXPECT_LT(drawn.face_colors.front()[0], 200);
  EXPECT_GT(drawn.face_colors.front()[2], 10);
}

}  // namespace
}  // namespace kerf::mesh_chunks_test
