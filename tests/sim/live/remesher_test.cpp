#include "sim/live/remesher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "bench/scenes/carved_field.h"
#include "geometry/field/sample_field.h"
#include "tests/geometry/sampled_field.h"
#include "tests/support/welded_mesh.h"

namespace kerf::remesher_test {
namespace {

using scenes::ballWithAHole;
using scenes::carve;
using scenes::carveAtRandom;

using Soup = std::vector<std::array<std::array<float, 3>, 3>>;

// The triangles as corners, each starting at its smallest corner in its original orientation, sorted.
template <class CornerOf>
void addTriangle(Soup& soup, const CornerOf& corner) {
  std::array<std::array<float, 3>, 3> t{corner(0), corner(1), corner(2)};
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  soup.push_back(t);
}
Soup soupOf(const Mesh& mesh) {
  Soup soup;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    addTriangle(soup, [&](int k) {
      const Vec3d p = roundedToFloat(mesh.corner(t, k));
      return std::array{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
    });
  std::sort(soup.begin(), soup.end());
  return soup;
}
Soup soupOf(const std::vector<MeshChunkPtr>& chunks) { return soupOf(weldedMesh(chunks)); }

// A reader that sees only changes.
struct Subscriber {
  std::map<std::array<int, 3>, MeshChunkPtr> chunks;
  std::uint64_t version = 0;
  void read(const Remesher& from) {
    for (const MeshChunkPtr& c : from.changedSince(version)) {
      EXPECT_GT(c->version, version);
      MeshChunkPtr& mine = chunks[{c->brick[0], c->brick[1], c->brick[2]}];
      if (mine) {
        EXPECT_GT(c->version, mine->version);
      }
      mine = c;
    }
    version = from.version();
  }
  std::vector<MeshChunkPtr> all() const {
    std::vector<MeshChunkPtr> out;
    for (const auto& [brick, c] : chunks) out.push_back(c);
    return out;
  }
};

TEST(Remesher, BakedFieldGivesTheTrianglesOfMarchingCubes) {
  const BrickField phi0 = ballWithAHole(2.0, 0.1);
  const Remesher remesher(phi0);
  const Soup whole = soupOf(marchingCubes(phi0));
  ASSERT_GT(whole.size(), 5000u);
  EXPECT_EQ(soupOf(remesher.changedSince(0)), whole);
  EXPECT_TRUE(remesher.changedSince(remesher.version()).empty());
  RemesherOptions alone;
  alone.is_parallel = false;
  const auto a = remesher.changedSince(0), b = Remesher(phi0, alone).changedSince(0);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    EXPECT_EQ(a[n]->vertices, b[n]->vertices);
    EXPECT_EQ(a[n]->triangles, b[n]->triangles);
  }
}

TEST(Remesher, EveryCarveLeavesTheTrianglesOfMarchingCubesOfTheWholeField) {
  const double r = 1.2;
  const BrickField phi0 = ballWithAHole(r, 0.1);
  OverlayField truth(phi0);
  Remesher remesher(phi0);
  Subscriber reader;
  std::mt19937 random(11);
  for (int n = 0; n < 60; ++n) {
    remesher.apply(carveAtRandom(truth, r, random));
    reader.read(remesher);
    ASSERT_EQ(soupOf(reader.all()), soupOf(marchingCubes(truth.flattened()))) << "after carve " << n;
    const Mesh mesh = weldedMesh(reader.all());
    expectClosedManifold(mesh);
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(Remesher, AnySingleNodeThatChangesMakesTheSameMeshAsFromScratch) {
  // Noise around zero, where the correction of one node moves the vertices of second neighbours.
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(-0.15f, 0.15f);
  BrickField phi0(0.1, 0.4f);
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 3; ++z)
        for (float& v : phi0.brick(phi0.touch({x, y, z}))) v = value(random);
  OverlayField truth(phi0);
  Remesher remesher(phi0);
  std::vector<MeshChunkPtr> before = remesher.changedSince(0);
  // Corners, edges and faces of the middle brick, and of the rim bricks, whose cells reach missing bricks.
  for (const int bx : {0, 1, 2})
    for (const int i : {0, 1, 4, 6, 7})
      for (const int j : {0, 3, 7})
        for (const int k : {0, 7}) {
          BrickEdit edit;
          edit.brick = {bx, 1, bx == 1 ? 1 : 2};
          edit.phi = *truth.valuesAt(edit.brick);
          float& v = edit.phi[static_cast<std::size_t>(nodeOffset(i, j, k))];
          v = -v;
          truth.set(edit);
          remesher.apply(std::span(&edit, 1));
          const BrickField whole = truth.flattened();
          const Remesher fresh(whole);
          // Normals too: they read farther than positions.
          const auto a = remesher.changedSince(0), b = fresh.changedSince(0);
          std::map<std::uint64_t, MeshChunkPtr> by_brick;
          for (const auto& c : a)
            if (!c->isEmpty()) by_brick[coordKey(c->brick)] = c;
          ASSERT_EQ(by_brick.size(), b.size());
          for (const auto& c : b) {
            const auto it = by_brick.find(coordKey(c->brick));
            ASSERT_NE(it, by_brick.end());
            ASSERT_EQ(it->second->vertices, c->vertices);
            ASSERT_EQ(it->second->normals, c->normals);
            ASSERT_EQ(it->second->triangles, c->triangles);
          }
        }
}

TEST(Remesher, TenThousandCarvesEndWhereARebuildBegins) {
  const double r = 3.0;
  const BrickField phi0 = ballWithAHole(r, 0.1);
  OverlayField truth(phi0);
  Remesher remesher(phi0);
  Subscriber reader;
  std::mt19937 random(2);
  for (int n = 0; n < 10'000; ++n) {
    remesher.apply(carveAtRandom(truth, r, random));
    if (n % 97 == 0) reader.read(remesher);  // often enough that the log is compacted in between
  }
  reader.read(remesher);
  const Mesh whole = marchingCubes(truth.flattened());
  EXPECT_EQ(soupOf(reader.all()), soupOf(whole));
  EXPECT_EQ(soupOf(remesher.changedSince(0)), soupOf(whole));
  EXPECT_EQ(remesher.field().flattened().stateHash(), truth.flattened().stateHash());
  expectClosedManifold(weldedMesh(reader.all()));
}

TEST(Remesher, TheLastEditOfABrickWinsAndOldValuesAgainChangeNothing) {
  const BrickField phi0 = ballWithAHole(1.0, 0.1);
  Remesher remesher(phi0);
  BrickEdit full, original;
  full.brick = original.brick = phi0.brickCoord(0);
  original.phi = phi0.brick(0);
  full.phi.fill(-0.2f);
  const std::array both{full, original};
  EXPECT_GT(remesher.apply(both), 0u);
  EXPECT_EQ(remesher.version(), 1u);  // meshed again, but the same
  EXPECT_TRUE(remesher.changedSince(1).empty());
  EXPECT_EQ(remesher.apply(std::span(&original, 1)), 0u);
  EXPECT_EQ(remesher.apply({}), 0u);
  EXPECT_GT(remesher.apply(std::span(&full, 1)), 0u);
  EXPECT_EQ(remesher.version(), 2u);
}

TEST(Remesher, WhatIsCutAwayWhollyLeavesEmptyChunks) {
  const BrickField phi0 = ballWithAHole(0.5, 0.1);
  OverlayField truth(phi0);
  Remesher remesher(phi0);
  Subscriber reader;
  reader.read(remesher);
  ASSERT_GT(weldedMesh(reader.all()).triangles.size(), 0u);
  remesher.apply(carve(truth, Vec3d::Zero(), 2.0));
  reader.read(remesher);
  for (const auto& c : reader.all()) EXPECT_TRUE(c->isEmpty());
}

TEST(Remesher, NormalsAreUnitPointOutwardsAndAgreeAcrossChunks) {
  const double r = 2.0;
  Box3 box;
  box.add(Vec3d::Zero());
  box.grow(r);
  const BrickField phi0 = sampleDistance([r](const Vec3d& p) { return p.norm() - r; }, box, 0.1);
  std::map<std::array<float, 3>, Vec3f> at;
  for (const MeshChunkPtr& c : Remesher(phi0).changedSince(0)) {
    ASSERT_EQ(c->normals.size(), c->vertices.size());
    for (std::size_t v = 0; v < c->vertices.size(); ++v) {
      const Vec3f p = c->vertices[v], n = c->normals[v];
      EXPECT_NEAR(n.norm(), 1, 1e-5);
      EXPECT_GT(n.dot(p.normalized()), 0.998f);  // second order in h / r = 1 / 20
      const auto [it, is_new] = at.try_emplace({p[0], p[1], p[2]}, n);
      EXPECT_EQ(it->second, n);
      static_cast<void>(is_new);
    }
  }
  EXPECT_GT(at.size(), 5000u);
}

}  // namespace
}  // namespace kerf::remesher_test
