// Winding numbers by rays against winding numbers by solid angles, and a solid with very many cavities.
#include "preprocess/close/winding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "preprocess/close/close.h"
#include "tests/geometry/ball_mesh.h"

namespace kerf::winding_test {
namespace {

/// A ball of 8 mm with small cavities in it, `cavities` along each axis.
Mesh sponge(int cavities, int around) {
  Mesh mesh = ballMesh(Vec3d::Zero(), 8, 60);
  const double step = 8.0 / cavities;
  for (int i = 0; i < cavities; ++i)
    for (int j = 0; j < cavities; ++j)
      for (int k = 0; k < cavities; ++k)
        append(mesh,
               ballMesh(step * (Vec3d(i, j, k) - Vec3d::Constant(0.5 * (cavities - 1))), 0.3 * step, around, true));
  return mesh;
}

TEST(Winding, RaysAgreeWithSolidAngles) {
  const Mesh mesh = sponge(3, 12);
  const internal::RayWinding rays(mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-9, 9);
  int inside = 0, decided = 0;
  for (int n = 0; n < 2000; ++n) {
    const Vec3d p(place(random), place(random), place(random));
    const auto winding = rays.at(p, [](std::uint32_t) { return false; });
    if (!winding) continue;
    ++decided;
    ASSERT_EQ(*winding, std::lround(internal::windingNumber(mesh, p))) << p.transpose();
    inside += *winding;
  }
  EXPECT_GT(decided, 1990);
  EXPECT_GT(inside, 300);
  EXPECT_LT(inside, decided);
  EXPECT_FALSE(rays.at(mesh.corner(0, 0), [](std::uint32_t) { return false; })) << "on the surface";
  EXPECT_EQ(rays.at({100, 0, 0}, [](std::uint32_t) { return false; }), 0) << "outside the grid";
}

TEST(Winding, ThousandsOfCavitiesStayCavities) {
  const Mesh mesh = sponge(14, 6);
  const auto solid = closeMesh(mesh, {});
  ASSERT_TRUE(solid) << solid.error().message();
  EXPECT_EQ(solid->mesh.triangles.size(), mesh.triangles.size());
  EXPECT_NEAR(signedVolume(solid->mesh), signedVolume(mesh), 1e-3);
  EXPECT_EQ(solid->report.triangles_flipped, 0u);
}

}  // namespace
}  // namespace kerf::winding_test
