// A mesh that turns fills its solid of revolution.
#include "geometry/tool/turned_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench/scenes/fluted_mesh.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/tool/mesh_shape.h"
#include "geometry/tool/plunge.h"

namespace kerf::turned_mesh_test {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(TurnedMesh, AFlutedHeadIsTheSolidThatItsEdgesSweep) {
  const Mesh mesh = flutedMesh([](double) { return 0.8; }, 4);
  ASSERT_TRUE(checkMesh(mesh).print_ready);
  const TurnedMesh turned = turnedMesh(mesh, 0, 4);
  EXPECT_FALSE(turned.second_ring_at);
  EXPECT_TRUE(turned.hollows.empty());
  EXPECT_NEAR(turned.outline.largestRadius(), 0.8, 1e-6);
  EXPECT_NEAR(turned.volume_mm3 / (kPi * 0.64 * 4), 1, 0.01);
  EXPECT_LT(turned.mesh_volume_mm3, 0.9 * turned.volume_mm3);
  EXPECT_TRUE(shapeOf(turned)->isConvex());
}

// No point of the turning mesh is outside, and every point inside is passed by the mesh at some angle.
TEST(TurnedMesh, HoldsEveryAngleOfTheMeshAndNothingElse) {
  const Mesh mesh = flutedMesh([](double z) { return 0.4 + 0.1 * z; }, 4, {.sides = 40, .rings = 20});
  const auto turned = shapeOf(turnedMesh(mesh, 0, 4));
  const MeshShape exact(mesh);
  int inside = 0;
  for (int i = 0; i < 40; ++i)
    for (int k = 0; k < 40; ++k) {
      const double r = 0.9 * i / 39, z = -0.1 + 4.2 * k / 39;
      double least = 1e9;
      for (int a = 0; a < 360; ++a) {
        const double angle = 2 * kPi * a / 360;
        least = std::min(least, exact.distance({r * std::cos(angle), r * std::sin(angle), z}));
      }
      const double d = turned->distance({0, -r, z});
      EXPECT_LE(d, least + 0.002) << r << " " << z;
      if (least > 0) {
        EXPECT_GE(d, least - 0.01) << r << " " << z;  // convex to 3 um; the edges of flutes between two angles
      }
      inside += d < 0;
    }
  EXPECT_GT(inside, 700);
}

// As a trephine: a tube below a disc.
TEST(TurnedMesh, ATubeLeavesItsCore) {
  constexpr double kOuter = 1.5, kInner = 1.2, kDeep = 5;
  const Mesh tube = tubeMesh(kOuter, kInner, kDeep, 6, 32);
  ASSERT_TRUE(checkMesh(tube).print_ready);
  const TurnedMesh turned = turnedMesh(tube, 0, 6);
  ASSERT_EQ(turned.hollows.size(), 1u);
  const double inner = kInner * std::cos(kPi / 32);  // middle of a chord
  const auto shape = shapeOf(turned);
  EXPECT_NEAR(shape->distance({0, 0, 1}), inner, 0.002);
  EXPECT_NEAR(shape->distance({0, 1.35, 1}), -0.5 * (kOuter - inner), 0.02);
  EXPECT_NEAR(shape->distance({0, 0, kDeep - 0.1}), 0.1, 0.003);
  EXPECT_NEAR(shape->distance({0, 0, -0.5}), inner, 0.003) << "the hollow has no floor";
  EXPECT_LT(shape->distance({0, 0, kDeep + 0.5}), -0.4);
  const double ring = kPi * (kOuter * kOuter - inner * inner);
  EXPECT_NEAR(internal::turnedPlunge(turned.outline, turned.hollows, 3), 3 * ring, 0.002 * ring);
  EXPECT_NEAR(internal::turnedPlunge(turned.outline, turned.hollows, 6), 5 * ring + kPi * kOuter * kOuter, 0.01);
}

TEST(TurnedMesh, ASecondRingIsNamedByItsHeight) {
  Mesh mesh = tubeMesh(1, 0, 0, 4, 16), handle = mesh;
  for (Vec3d& p : handle.vertices) p += Vec3d(5, 0, 2);
  append(mesh, handle);
  EXPECT_FALSE(turnedMesh(mesh, 0, 1.99).second_ring_at);
  const TurnedMesh turned = turnedMesh(mesh, 0, 4);
  ASSERT_TRUE(turned.second_ring_at);
  EXPECT_NEAR(*turned.second_ring_at, 2, 0.002);
}

// The step of a shank and a thin rim lie between two levels.
TEST(TurnedMesh, StepsAndRimsStayWhereTheyAre) {
  Mesh mesh = tubeMesh(1, 0, 0, 2, 64);
  Mesh rim = tubeMesh(3, 0, 0, 0.0005, 64);  // thinner than the spacing of the levels
  for (Vec3d& p : rim.vertices) p[2] += 2.5;
  append(mesh, rim);
  const TurnedMesh turned = turnedMesh(mesh, 0, 4);
  EXPECT_NEAR(turned.outline.radiusAt(1.99), 1, 1e-6);
  EXPECT_NEAR(turned.outline.radiusAt(2.01), 0, 1e-9);
  EXPECT_NEAR(turned.outline.largestRadius(), 3, 1e-6);
  EXPECT_NEAR(turned.outline.highestAsWideAs(2.9), 2.5, 0.004);
  EXPECT_NEAR(shapeOf(turned)->distance({0, 0, 2.25}), 0.25, 0.004) << "no surface on the axis";
  EXPECT_NEAR(shapeOf(turned)->distance({0, 1, 2.1}), 0.1, 0.004);
}

// In float32 many heights lie below themselves: the collar begins where the cutting part ends, and is not part of it.
TEST(TurnedMesh, AnEndOfThePartKeepsWhatIsBeyondOut) {
  for (const double height : {0.35, 0.7, 1.4, 4.1, 4.3}) {
    const double radii[] = {1, 1, 3, 3}, heights[] = {0, height, height, height + 2};
    const auto at = [&](std::uint32_t ring, std::uint32_t side) {
      const double angle = 2 * kPi * side / 48;
      return roundedToFloat(Vec3d(radii[ring] * std::cos(angle), radii[ring] * std::sin(angle), heights[ring]));
    };
    const Mesh collar = ringMesh(48, 4, at, {0, 0, 0}, {0, 0, height + 2});
    EXPECT_NEAR(turnedMesh(collar, 0, height).outline.largestRadius(), 1, 1e-6) << height;
    EXPECT_TRUE(shapeOf(turnedMesh(collar, 0, height))->isConvex()) << height;
    Mesh down = collar;  // a head, and a neck above it
    for (Vec3d& p : down.vertices) p = Vec3d(p[0], -p[1], height + 2 - p[2]);
    EXPECT_NEAR(turnedMesh(down, 2, height + 2).outline.largestRadius(), 1, 1e-6) << height;
    EXPECT_NEAR(turnedMesh(down, 0, height + 2).outline.largestRadius(), 3, 1e-6) << height;
  }
}

}  // namespace
}  // namespace kerf::turned_mesh_test
