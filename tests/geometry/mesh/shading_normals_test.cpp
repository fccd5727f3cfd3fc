#include "geometry/mesh/shading_normals.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/geometry/ball_mesh.h"

namespace kerf::shading_normals_test {
namespace {

/// A tetrahedron without any symmetry.
Mesh skewTetrahedron() {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {3, 0.2, 0.1}, {0.7, 4, -0.3}, {0.4, 1.1, 6}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

TEST(ShadingNormals, CreaseKeepsATetrahedronSharpAndASphereSmooth) {
  for (const Vec3f& n : cornerNormals(skewTetrahedron(), 0.6)) EXPECT_NEAR(n.norm(), 1, 1e-6);

  const Mesh ball = ballMesh(Vec3d::Zero(), 2, 32), solid = skewTetrahedron();
  const std::vector<Vec3f> smooth = cornerNormals(ball, 0.7), sharp = cornerNormals(solid, 0.7);
  for (std::size_t c = 0; c < smooth.size(); ++c) {
    const Vec3d outward = ball.vertices[ball.triangles[c / 3][c % 3]].normalized();
    EXPECT_GT(smooth[c].cast<double>().dot(outward), std::cos(0.02));
  }
  for (std::size_t c = 0; c < sharp.size(); ++c)
    EXPECT_GT(sharp[c].cast<double>().dot(doubleAreaVector(solid, c / 3).normalized()), 1 - 1e-6);
}

TEST(ShadingNormals, ATriangleWithoutAreaTakesThoseAroundIt) {
  Mesh mesh = skewTetrahedron();
  mesh.triangles.push_back({1, 1, 3});
  for (const Vec3f& n : cornerNormals(mesh, 0.7)) EXPECT_NEAR(n.norm(), 1, 1e-6);

  Mesh alone;
  alone.vertices = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  alone.triangles = {{0, 1, 2}};
  for (const Vec3f& n : cornerNormals(alone, 0.7)) EXPECT_EQ(n, Vec3f(Vec3f::UnitZ()));
}

}  // namespace
}  // namespace kerf::shading_normals_test
