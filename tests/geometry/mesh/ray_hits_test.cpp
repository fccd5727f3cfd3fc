#include "geometry/mesh/ray_hits.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/preprocess/solid_checks.h"

namespace kerf::ray_hits_test {
namespace {

TEST(RayHits, ABoxIsEnteredAndLeftOnceWhereverItIsMet) {
  const Mesh m = box({-1, -2, -3}, {1, 2, 3});
  // In a face, on the diagonal between its two triangles, on a vertex of an edge, beside.
  for (const Vec3d& at : {Vec3d(0.3, 0.2, 9), Vec3d(0, 0, 9), Vec3d(0.5, 1, 9), Vec3d(-0.5, -1, 9)}) {
    const auto hits = rayHits(m, at, {0, 0, -2});
    ASSERT_EQ(hits.size(), 2u) << at.transpose();
    EXPECT_TRUE(hits[0].enters);
    EXPECT_FALSE(hits[1].enters);
    EXPECT_NEAR(hits[0].way, 3, 1e-12);  // in lengths of the direction vector
    EXPECT_NEAR(hits[1].way, 6, 1e-12);
  }
  EXPECT_TRUE(rayHits(m, {1.1, 0, 9}, {0, 0, -1}).empty());
  EXPECT_TRUE(rayHits(m, {0, 0, 9}, {0, 0, 1}).empty()) << "what lies behind does not count";
  EXPECT_EQ(rayHits(m, {0, 0, 0}, {0, 0, 1}).size(), 1u) << "from inside";
}

TEST(RayHits, LieOnASphereAndAlternate) {
  const double r = 5;
  const Mesh m = ball(60, 120, r);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> in(-1, 1);
  for (int n = 0; n < 200; ++n) {
    const Vec3d from = 20 * Vec3d(in(random), in(random), in(random)).normalized();
    const Vec3d through = 0.9 * r * Vec3d(in(random), in(random), in(random)) / std::sqrt(3.0);
    const auto hits = rayHits(m, from, through - from);
    ASSERT_EQ(hits.size(), 2u);
    for (const RayHit& hit : hits) {
      const Vec3d p = from + hit.way * (through - from);
      EXPECT_NEAR(p.norm(), r, 0.01);
      const Vec3d normal = doubleAreaVector(m, hit.triangle).normalized();
      EXPECT_EQ(hit.enters, normal.dot(through - from) < 0);
    }
    EXPECT_TRUE(hits[0].enters && !hits[1].enters);
  }
}

// Through the vertices of a mesh: never a gap, never an odd number.
TEST(RayHits, ThroughVerticesEnterAndLeave) {
  const Mesh m = ball(12, 24, 5);
  for (const Vec3d& p : m.vertices) {
    if (p.head<2>().norm() > 4.9) continue;  // along the equator the ray may only touch
    const auto hits = rayHits(m, {p.x(), p.y(), 20}, {0, 0, -1});
    ASSERT_EQ(hits.size(), 2u) << p.transpose();
    EXPECT_NEAR(20 - hits[0].way, std::abs(p.z()), 1e-6);
  }
}

}  // namespace
}  // namespace kerf::ray_hits_test
