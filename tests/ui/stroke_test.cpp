#include "ui/app/tool/stroke.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tool/tool_file.h"
#include "sim/live/remesher.h"
#include "tests/sim/block_scene.h"
#include "ui/app/view/live_scene.h"

namespace kerf::stroke_test {
namespace {

// A ball of 3 mm about the origin, with a hole of 1 mm radius and 1 mm depth in its top.
struct BallWithHole {
  BallWithHole() {
    Box3 box;
    box.add(Vec3d::Constant(-3.5));
    box.add(Vec3d::Constant(3.5));
    loaded = test::bakedFrom([](const Vec3d& p) { return p.norm() - 3; }, box, 0.1);
    Remesher remesher(loaded->phi0(), {.is_parallel = false});
    std::vector<BrickEdit> edits;
    for (const BakedObject::Slot& slot : loaded->slots()) {
      BrickEdit edit{slot.brick, {}};
      for (int n = 0; n < kBrickNodes; ++n) {
        const Vec3d p = 0.1 * (kBrickSide * slot.brick + Vec3i(n >> 6, n >> 3 & 7, n & 7)).cast<double>();
        const double hole = std::max(std::hypot(p[0], p[1]) - 1, 2 - p[2]);
        edit.phi[static_cast<std::size_t>(n)] = std::max(slot.phi[n], static_cast<float>(-hole));
      }
      edits.push_back(edit);
    }
    remesher.apply(edits);
    surface.update(remesher.changedSince(0));
    scene.update(std::vector<ObjectChunks>{{1, remesher.changedSince(0)}}, {});
  }
  std::shared_ptr<const BakedObject> loaded;
  LiveSurface surface;
  LiveScene scene;
};

Ray down(double x, double y) { return {{x, y, 20}, -Vec3d::UnitZ()}; }

TEST(LiveSurface, ARayMeetsWhatIsThereNowAndEntryWhatWasLoaded) {
  const BallWithHole scene;
  const auto hit = scene.surface.hit(down(0.02, 0.03));
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->point[2], 2, 0.02);
  EXPECT_GT(hit->normal[2], 0.99);
  const auto way = entry(scene.loaded->phi0(), down(0.02, 0.03), 0, 100);
  ASSERT_TRUE(way);
  EXPECT_NEAR(20 - *way, 3, 0.01);

  EXPECT_FALSE(scene.surface.hit(down(3.2, 0)));
  EXPECT_FALSE(entry(scene.loaded->phi0(), down(3.2, 0), 0, 100));
  EXPECT_FALSE(scene.surface.hit({{0, 0, 20}, Vec3d::UnitZ()})) << "behind the ray";
  EXPECT_NEAR(scene.surface.bounds().max[0], 3, 0.02);
}

TEST(DepthBelow, IsToTheFirstAirAlongTheAxisHoweverDeep) {
  const BallWithHole scene;
  const BrickField& loaded = scene.loaded->phi0();
  const Vec3d up = Vec3d::UnitZ(), slant = Vec3d(1, 0, 1).normalized();
  EXPECT_NEAR(*depthBelow(loaded, {0, 0, 2.5}, up), 0.5, 0.01);
  EXPECT_NEAR(*depthBelow(loaded, {0, 0, -2.9}, up), 5.9, 0.01) << "deeper than the band of distances";
  EXPECT_NEAR(*depthBelow(loaded, {0, 0, 0}, slant), 3, 0.01);
  EXPECT_NEAR(*depthBelow(loaded, {0, 0, 3.7}, up), -0.7, 0.01) << "in air it is negative";
  EXPECT_FALSE(depthBelow(loaded, {5, 0, 3}, up)) << "there is nothing below";
}

TEST(LiveSurface, ChunksAreReplacedAndRemoved) {
  const BallWithHole scene;
  LiveSurface surface;
  Remesher remesher(scene.loaded->phi0(), {.is_parallel = false});
  surface.update(remesher.changedSince(0));
  const std::size_t before = surface.triangleCount();
  EXPECT_GT(before, 1000u);
  surface.update(remesher.changedSince(0));
  EXPECT_EQ(surface.triangleCount(), before);
  for (const MeshChunkPtr& chunk : remesher.changedSince(0)) {
    MeshChunk empty;
    empty.brick = chunk->brick;
    const MeshChunkPtr gone[] = {std::make_shared<const MeshChunk>(empty)};
    surface.update(gone);
  }
  EXPECT_EQ(surface.triangleCount(), 0u);
  EXPECT_TRUE(surface.bounds().isEmpty());
}

TEST(Stroke, TheToolStandsOnTheSurfaceAsItWasLoadedAlsoInsideACut) {
  const BallWithHole scene;
  for (const double x : {0.02, 0.5, 0.9}) {
    const auto at = toolOver(scene.scene, scene.loaded->phi0(), down(x, 0.03), Plunge{});
    ASSERT_TRUE(at) << x;
    EXPECT_LT(std::acos(at->normal.dot(Vec3d(x, 0.03, 3).normalized())), 0.06) << x;
    EXPECT_NEAR(at->depth, at->normal.dot(3 * at->normal - at->point), 0.03) << x;
    EXPECT_NEAR((at->T_world_tool.rotation * Vec3d::UnitZ() - at->normal).norm(), 0, 1e-9);
  }
  EXPECT_FALSE(toolOver(scene.scene, scene.loaded->phi0(), down(3.3, 0), Plunge{}));
}

TEST(Stroke, ItIsAnchoredOutsideAndPointsAtWhatWasLoaded) {
  const BallWithHole scene;
  Mesh head;
  head.vertices = {{0, 0, 0}, {0.5, 0, 0.5}, {-0.5, 0, 0.5}};
  const auto at = toolOver(scene.scene, scene.loaded->phi0(), down(0.02, 0.03), Plunge{});
  ASSERT_TRUE(at);
  const Stroke stroke(scene.loaded->phi0(), *at, head);
  EXPECT_NEAR(stroke.anchor().norm(), 3, 0.01);
  for (const Vec3d& v : head.vertices) EXPECT_GT((stroke.start() * v).norm(), 3);
  EXPECT_NEAR(stroke.depthOf({0.02, 0.03, 2.5}), 0.5, 0.01);
  EXPECT_LT(stroke.depthOf({0.02, 0.03, 3.2}), 0);

  EXPECT_NEAR(stroke.pointerOf(down(1, 0)).norm(), 3, 0.01);
  // Beside the object: in the plane through the anchor.
  const Vec3d beside = stroke.pointerOf(down(8, 0));
  EXPECT_NEAR(stroke.axis().dot(beside - stroke.anchor()), 0, 1e-9);
  EXPECT_NEAR(beside[0], 8, 1e-9);
}

TEST(Stroke, ADiscStandsOnItsRimAndASawOnItsTeeth) {
  const BallWithHole scene;
  for (const char* const id : {"disc-22", "saw-reciprocating-25"}) {
    const auto file = findToolFile(id, defaultToolFolders());
    ASSERT_TRUE(file);
    const auto tool = readTool(*file);
    ASSERT_TRUE(tool);
    const Plunge plunge = plungeOf(*tool);
    EXPECT_NEAR(plunge.reach, std::string(id) == "disc-22" ? 11 : 0, 0.05) << id;
    const auto at = toolOver(scene.scene, scene.loaded->phi0(), down(1.8, 0), plunge);
    ASSERT_TRUE(at);
    EXPECT_NEAR((at->T_world_tool.rotation * plunge.direction + at->normal).norm(), 0, 1e-9);
    const Stroke stroke(scene.loaded->phi0(), *at, {});
    const double first = plunge.reach - stroke.axis().dot(stroke.start().translation - stroke.anchor());
    EXPECT_NEAR(first, -0.3, 1e-9) << "above the surface";
    EXPECT_NEAR(stroke.depthOf(stroke.start().translation), -0.3, 0.02);
  }
}

}  // namespace
}  // namespace kerf::stroke_test
