#include "geometry/tool/mesh_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/geometry/ball_mesh.h"
#include "tests/geometry/sampled_field.h"

namespace kerf::mesh_shape_test {
namespace {

struct Random {
  std::mt19937 engine{13};
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vec3d point(double reach) { return {(*this)(-reach, reach), (*this)(-reach, reach), (*this)(-reach, reach)}; }
};

Mesh boxMesh(const Box3& box) {
  Mesh mesh;
  for (int c = 0; c < 8; ++c)
    mesh.vertices.emplace_back(c & 1 ? box.max[0] : box.min[0], c & 2 ? box.max[1] : box.min[1],
                               c & 4 ? box.max[2] : box.min[2]);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TEST(MeshShape, OfABoxIsTheBoxsFormula) {
  const Box3 box{Vec3d(-0.5, -0.2, -1), Vec3d(0.5, 0.3, 2)};
  const MeshShape mesh(boxMesh(box));
  const BoxShape exact(box);
  Random random;
  for (int n = 0; n < 5000; ++n) {
    const Vec3d p = random.point(3);
    EXPECT_NEAR(mesh.distance(p), exact.distance(p), 1e-12) << p.transpose();
  }
  // Straight out from edges and corners, pseudonormals decide the side.
  for (const Vec3d& p : {Vec3d(0.5, 0.3, 2), Vec3d(0.5, 0.3, 0), Vec3d(-0.5, -0.2, -1)}) {
    EXPECT_GT(mesh.distance(p + 0.01 * (p - box.center())), 0);
    EXPECT_LT(mesh.distance(p - 0.01 * (p - box.center())), 0);
  }
}

TEST(MeshShape, SignIsRightInsideAndOutsideAHollowBall) {
  Mesh shell = ballMesh({0, 0, 0}, 1, 24);
  append(shell, ballMesh({0, 0, 0}, 0.5, 24, true));
  const MeshShape mesh(shell);
  Random random;
  for (int n = 0; n < 5000; ++n) {
    const Vec3d p = random.point(1.5);
    const double r = p.norm(), exact = std::max(r - 1, 0.5 - r);
    EXPECT_NEAR(mesh.distance(p), exact, 0.01) << p.transpose();  // chords of 24 rings: 0.9 % of the radius
  }
}

TEST(HalfShape, IsTheSolidAboveALevel) {
  const auto ball = std::make_shared<MeshShape>(ballMesh({0, 0, 0}, 1, 24));
  const HalfShape above(ball, 0.3);
  Random random;
  for (int n = 0; n < 2000; ++n) {
    const Vec3d p = random.point(1.5);
    EXPECT_EQ(above.distance(p) < 0, ball->distance(p) < 0 && p[2] > 0.3);
  }
  EXPECT_EQ(above.bounds().min[2], 0.3);
}

}  // namespace
}  // namespace kerf::mesh_shape_test
