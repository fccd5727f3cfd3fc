#include "geometry/mesh/mesh_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/geometry/ball_mesh.h"

namespace kerf::mesh_distance_test {
namespace {

struct Random {
  std::mt19937 engine{7};
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vec3d point(double reach) { return {(*this)(-reach, reach), (*this)(-reach, reach), (*this)(-reach, reach)}; }
};

// By another way than the class: the foot in the plane if it is inside, else the nearest of the three segments.
double distanceTo(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p) {
  const auto toSegment = [&](const Vec3d& u, const Vec3d& v) {
    const double length = (v - u).squaredNorm();
    const double at = length > 0 ? std::clamp((p - u).dot(v - u) / length, 0.0, 1.0) : 0;
    return (p - u - at * (v - u)).norm();
  };
  const Vec3d n = (b - a).cross(c - a);
  if (n.norm() > 0) {
    const Vec3d foot = p - n.dot(p - a) / n.squaredNorm() * n;
    const auto side = [&](const Vec3d& u, const Vec3d& v) { return n.dot((v - u).cross(foot - u)) >= 0; };
    if (side(a, b) && side(b, c) && side(c, a)) return (p - foot).norm();
  }
  return std::min({toSegment(a, b), toSegment(b, c), toSegment(c, a)});
}

double bruteDistance(const Mesh& mesh, const Vec3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    least = std::min(least, distanceTo(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), p));
  return least;
}

// Winding number by solid angles: van Oosterom & Strackee 1983.
bool isInside(const Mesh& mesh, const Vec3d& p) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d a = mesh.corner(t, 0) - p, b = mesh.corner(t, 1) - p, c = mesh.corner(t, 2) - p;
    const double x = a.norm(), y = b.norm(), z = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y);
  }
  return sum > 2 * std::numbers::pi;
}

// A ball with deep spikes: sharp corners, where the normal of the nearest triangle alone gives wrong sides.
Mesh spikyBall() {
  Mesh mesh = ballMesh({0, 0, 0}, 1, 12);
  Random random;
  for (Vec3d& p : mesh.vertices) p *= random(0.4, 1.6);
  return mesh;
}

// Every triangle with three vertices of its own, as STL holds them.
Mesh loose(const Mesh& mesh) {
  Mesh out;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) out.vertices.push_back(mesh.corner(t, k));
    out.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return out;
}

TEST(MeshDistance, EqualsTheLeastOverAllTriangles) {
  Mesh mesh = spikyBall();
  mesh.triangles.push_back({5, 5, 6});  // no area
  const MeshDistance distance(mesh);
  Random random;
  for (int n = 0; n < 2000; ++n) {
    const Vec3d p = random.point(2);
    const NearestOnMesh nearest = distance.nearest(p);
    ASSERT_NEAR(nearest.distance_mm, bruteDistance(mesh, p), 1e-12) << p.transpose();
    EXPECT_NEAR((nearest.point - p).norm(), nearest.distance_mm, 1e-12);
    const std::size_t t = nearest.triangle;
    EXPECT_NEAR(distanceTo(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), nearest.point), 0, 1e-12);
  }
  EXPECT_EQ(distance.nearest(mesh.vertices[17]).distance_mm, 0) << "exactly 0 at a vertex";
}

TEST(MeshDistance, SignIsThatOfTheWindingNumber) {
  for (const Mesh& mesh : {spikyBall(), loose(spikyBall())}) {
    const MeshDistance distance(mesh);
    EXPECT_TRUE(distance.isClosed());
    Random random;
    int inside = 0;
    for (int n = 0; n < 2000; ++n) {
      const Vec3d p = random.point(1.6);
      const NearestOnMesh nearest = distance.nearest(p);
      inside += nearest.signed_mm < 0;
      ASSERT_EQ(nearest.signed_mm < 0, isInside(mesh, p)) << p.transpose();
      EXPECT_EQ(std::abs(nearest.signed_mm), nearest.distance_mm);
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(MeshDistance, OfAnOpenMeshNamesTheBoundary) {
  Mesh sheet;  // 2 x 2 squares in z = 0, facing +z
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) sheet.vertices.emplace_back(x, y, 0);
  for (std::uint32_t y = 0; y < 2; ++y)
    for (std::uint32_t x = 0; x < 2; ++x) {
      const std::uint32_t a = 3 * y + x;
      sheet.triangles.push_back({a, a + 1, a + 4});
      sheet.triangles.push_back({a, a + 4, a + 3});
    }
  const MeshDistance distance(sheet);
  EXPECT_EQ(distance.boundaryEdges(), 8u);
  EXPECT_FALSE(distance.isClosed());

  const NearestOnMesh above = distance.nearest({1.2, 0.9, 0.5}), below = distance.nearest({1, 1, -0.5});
  EXPECT_EQ(above.signed_mm, 0.5);
  EXPECT_EQ(below.signed_mm, -0.5);
  EXPECT_FALSE(above.is_on_boundary);
  EXPECT_FALSE(below.is_on_boundary) << "the middle vertex has triangles all around";
  for (const Vec3d& p : {Vec3d(3, 1, 0.5), Vec3d(3, 3, 0.5), Vec3d(2, 0.5, 0.5)})
    EXPECT_TRUE(distance.nearest(p).is_on_boundary) << p.transpose();
}

TEST(MeshDistance, NeitherSliversNorCopiesCloseAMesh) {
  Mesh mesh = ballMesh(Vec3d::Zero(), 3, 12);
  EXPECT_TRUE(MeshDistance(mesh).isClosed());
  Mesh twice = mesh;
  twice.triangles.push_back(mesh.triangles[5]);
  EXPECT_FALSE(MeshDistance(twice).isClosed());
  const Triangle gone = mesh.triangles[5];
  mesh.triangles.erase(mesh.triangles.begin() + 5);
  for (int k = 0; k < 3; ++k) mesh.triangles.push_back({gone[k], gone[(k + 1) % 3], gone[k]});
  const MeshDistance open(mesh);
  EXPECT_FALSE(open.isClosed());
  EXPECT_EQ(open.boundaryEdges(), 3u);
}

TEST(MeshDistance, ManyEqualTrianglesCostNoMore) {
  Mesh mesh = ballMesh(Vec3d::Zero(), 3, 12);
  for (int n = 0; n < 100'000; ++n) mesh.triangles.push_back(mesh.triangles[7]);
  const MeshDistance distance(mesh);
  const Vec3d middle = (mesh.corner(7, 0) + mesh.corner(7, 1) + mesh.corner(7, 2)) / 3;
  for (int n = 0; n < 20'000; ++n) ASSERT_EQ(distance.nearest(middle).triangle, 7u);  // minutes if each is tried
}

TEST(MeshDistance, FindsNothingBeyondTheLimit) {
  const MeshDistance distance(ballMesh({0, 0, 0}, 1, 24));
  EXPECT_FALSE(distance.nearest({3, 0, 0}, 1.99).isFound());
  EXPECT_NEAR(distance.nearest({3, 0, 0}, 2.01).distance_mm, 2, 1e-6);
  EXPECT_FALSE(MeshDistance(Mesh{}).nearest({0, 0, 0}).isFound());
}

}  // namespace
}  // namespace kerf::mesh_distance_test
