#include "sim/live/chunk_occlusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/field/sample_field.h"

namespace kerf::chunk_occlusion_test {
namespace {

constexpr double kVoxel = 0.1;

double boxAt(const Vec3d& p, const Vec3d& middle, const Vec3d& half) {
  const Vec3d q = (p - middle).cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

/// A plate of 8 x 8 x 4 mm, its top at z = 0, with a square hole, `half` mm to its walls, 1.5 mm deep, in the middle.
double plateWithHole(const Vec3d& p, double half) {
  return std::max(boxAt(p, {0, 0, -2}, {4, 4, 2}), -boxAt(p, {0, 0, 0}, {half, half, 1.5}));
}

struct Seen {
  Vec3d p, n;
  int light;
};
std::vector<Seen> occlusionOfAll(const BrickField& phi) {
  std::vector<Seen> seen;
  const Remesher remesher(phi, {.marching_cubes = {}, .is_parallel = false});
  for (const MeshChunkPtr& chunk : remesher.changedSince(0)) {
    const auto light = occlusionOf(*chunk, phi);
    EXPECT_EQ(light.size(), chunk->vertices.size());
    EXPECT_EQ(light, occlusionOf(*chunk, remesher.field()));
    for (std::size_t v = 0; v < light.size(); ++v)
      seen.push_back({chunk->vertices[v].cast<double>(), chunk->normals[v].cast<double>(), light[v]});
  }
  return seen;
}
BrickField plate(double half) {
  return sampleDistance([=](const Vec3d& p) { return plateWithHole(p, half); }, {{-4, -4, -4}, {4, 4, 0}}, kVoxel);
}

TEST(ChunkOcclusion, AFlatWallAndABallHaveAllTheLight) {
  for (const Seen& s : occlusionOfAll(plate(1)))
    if (std::abs(s.p[2]) < 0.01 && s.p.head<2>().cwiseAbs().minCoeff() > 1.4) {
      EXPECT_EQ(s.light, 255) << s.p.transpose();
    }
  const auto ball = sampleDistance([](const Vec3d& p) { return p.norm() - 2; }, {{-2, -2, -2}, {2, 2, 2}}, kVoxel);
  for (const Seen& s : occlusionOfAll(ball)) EXPECT_EQ(s.light, 255);
}

TEST(ChunkOcclusion, TheFloorOfAHoleIsDarkerTheNarrowerItIs) {
  const auto onFloor = [](double half, const Vec3d& middle) {
    int light = -1;
    for (const Seen& s : occlusionOfAll(plate(half)))
      if (s.n[2] > 0.9 && (s.p - middle).norm() < 0.1) light = s.light;
    return light;
  };
  const int wide = onFloor(1.6, {0, 0, -1.5}), narrow = onFloor(0.4, {0, 0, -1.5});
  const int corner = onFloor(1.6, {1.3, 1.3, -1.5});
  EXPECT_GT(wide, 200);
  EXPECT_LT(narrow, 150);
  EXPECT_GT(narrow, 0);
  EXPECT_LT(corner, wide - 30);
}

TEST(ChunkOcclusion, ChangesWithinItsReachAlone) {
  const BrickField whole = plate(0.4);
  OverlayField field(whole);
  BrickEdit edit{.brick = {3, 0, -2}, .phi = {}};  // a brick from (2.4, 0, -1.6) to (3.1, 0.7, -0.9) is entirely tissue
  edit.phi.fill(static_cast<float>(-kVoxel));
  const Remesher remesher(whole, {.marching_cubes = {}, .is_parallel = false});
  field.set(edit);
  Box3 box{{2.4, 0, -1.6}, {3.1, 0.7, -0.9}};
  box.grow(kOcclusionReach);
  for (const MeshChunkPtr& chunk : remesher.changedSince(0)) {
    const auto before = occlusionOf(*chunk, whole), after = occlusionOf(*chunk, field);
    for (std::size_t v = 0; v < before.size(); ++v)
      if (!box.contains(chunk->vertices[v].cast<double>())) {
        EXPECT_EQ(before[v], after[v]);
      }
  }
}

TEST(ChunkOcclusion, OfAnEmptyChunkIsEmpty) { EXPECT_TRUE(occlusionOf(MeshChunk{}, plate(1)).empty()); }

}  // namespace
}  // namespace kerf::chunk_occlusion_test
