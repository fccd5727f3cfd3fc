#include "geometry/compare/comparison.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <numbers>

#include "geometry/compare/deviation_picture.h"
#include "tests/geometry/ball_mesh.h"

namespace kerf::comparison_test {
namespace {

Comparison compared(const Mesh& first, const Mesh& second, const ComparisonOptions& options = {}) {
  const auto out = compareMeshes(first, MeshDistance(first), second, MeshDistance(second), options);
  EXPECT_TRUE(out) << out.error().message();
  return out.value_or(Comparison{});
}

Mesh boxMesh(const Vec3d& low, const Vec3d& high) {
  Mesh mesh;
  for (int c = 0; c < 8; ++c) mesh.vertices.push_back(Box3{low, high}.corner(c));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// n x n squares of 1 mm, facing +z.
Mesh sheet(const Vec3d& corner, std::uint32_t n) {
  Mesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y)
    for (std::uint32_t x = 0; x <= n; ++x) mesh.vertices.push_back(corner + Vec3d(x, y, 0));
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = (n + 1) * y + x;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  return mesh;
}

TEST(Comparison, OfTwoBallsIsTheDifferenceOfTheirRadii) {
  const Mesh small = ballMesh({1, 2, 3}, 5, 60), large = ballMesh({1, 2, 3}, 5.3, 60);
  const double chord = 5.3 * (1 - std::cos(std::numbers::pi / 120));  // how far flat triangles lie below the ball
  for (const double sign : {1.0, -1.0}) {
    const Comparison c = sign > 0 ? compared(small, large) : compared(large, small);
    for (const Deviations* d : {&c.of_first, &c.of_second}) {
      EXPECT_NEAR(d->mean_mm, sign * 0.3, 2 * chord);
      EXPECT_NEAR(d->rms_mm, 0.3, 2 * chord);
      EXPECT_NEAR(d->p95_mm, 0.3, 2 * chord);
      EXPECT_NEAR(d->largest().mm, sign * 0.3, 2 * chord);
      EXPECT_EQ(sign > 0 ? d->over : d->under, 1);
      EXPECT_EQ(d->within, 0);
      EXPECT_EQ(d->unchanged, 0);
      EXPECT_EQ(d->excluded_mm2, 0);
      EXPECT_GT(d->normals_agree, 0.99);
    }
    EXPECT_NEAR(c.of_second.area_mm2, surfaceArea(sign > 0 ? large : small), 1e-6);
    EXPECT_NEAR(c.hausdorff_mm(), 0.3, 2 * chord);
  }
}

TEST(Comparison, OfAMeshWithItselfIsExactlyZero) {
  const Mesh ball = ballMesh({30, -40, 50}, 5, 40);
  const Comparison c = compared(ball, ball);
  EXPECT_EQ(c.hausdorff_mm(), 0);
  EXPECT_EQ(c.of_first.rms_mm, 0);
  EXPECT_EQ(c.of_first.unchanged, 1);
  for (const float mm : c.of_second.at_vertex) EXPECT_EQ(mm, 0);
}

// The middle of a large triangle has no vertex near it.
TEST(Comparison, SamplesTheMiddleOfLargeTriangles) {
  Mesh flat, tent;
  flat.vertices = {{-10, -10, 0}, {10, -10, 0}, {10, 10, 0}, {-10, 10, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 3}};
  tent.vertices = flat.vertices;
  tent.vertices.emplace_back(0, 4, 1);  // 6 mm from the nearest side
  tent.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const Comparison c = compared(flat, tent);
  for (const float mm : c.of_first.at_vertex) EXPECT_TRUE(std::isnan(mm) || mm == 0) << mm;
  EXPECT_NEAR(c.of_first.most.mm, std::cos(std::atan(1.0 / 6)), c.of_first.spacing_mm / 6);
  EXPECT_LT((c.of_first.most.at - Vec3d(0, 4, 0)).norm(), 2 * c.of_first.spacing_mm);
  EXPECT_EQ(c.of_second.most.mm, 1);
}

// The corner of a cube lies r (sqrt 3 - 1) outside the cube with edges rounded to r.
TEST(Comparison, OfACubeAndARoundedOne) {
  constexpr double kHalf = 5, kRadius = 1;
  Mesh rounded = ballMesh({0, 0, 0}, kRadius, 64);
  for (Vec3d& p : rounded.vertices) p += (kHalf - kRadius) * p.unaryExpr([](double x) { return x < 0 ? -1.0 : 1.0; });
  const Comparison c = compared(boxMesh({-kHalf, -kHalf, -kHalf}, {kHalf, kHalf, kHalf}), rounded);
  EXPECT_NEAR(c.of_first.least.mm, -kRadius * (std::sqrt(3.0) - 1), 0.005);
  EXPECT_NEAR(c.of_first.least.at.cwiseAbs().minCoeff(), kHalf, 1e-9) << "at a corner";
  EXPECT_NEAR(c.of_second.least.mm, -kRadius * (1 - 1 / std::sqrt(3.0)), 0.01) << "from the round corner to a face";
  EXPECT_LT(c.of_second.most.mm, 1e-6);
}

TEST(Comparison, OfOpenSheetsLeavesOutTheOverhang) {
  const Mesh low = sheet({0, 0, 0}, 10), high = sheet({3, 0, 0.2}, 10);
  const Comparison c = compared(low, high);
  for (const Deviations* d : {&c.of_first, &c.of_second}) {
    EXPECT_NEAR(d->excluded_mm2, 30, 0.5);
    EXPECT_NEAR(d->area_mm2, 70, 0.5);
    EXPECT_NEAR(d->mean_mm, 0.2, 1e-12);
    EXPECT_NEAR(d->most.mm, 0.2, 1e-12);
    EXPECT_NEAR(d->least.mm, 0.2, 1e-12);
    EXPECT_EQ(d->over, 1);
  }
  EXPECT_TRUE(std::isnan(c.of_second.at_vertex.back())) << "beyond the end of the other sheet";
  EXPECT_NEAR(compared(low, high, {.tolerance_mm = 0.25}).of_first.within, 1, 0);

  const auto beside = compareMeshes(low, MeshDistance(low), sheet({20, 0, 0}, 2), MeshDistance(sheet({20, 0, 0}, 2)));
  ASSERT_FALSE(beside);
  EXPECT_EQ(beside.error().code, Error::Code::kEmpty);
}

TEST(Comparison, TellsThatOneMeshIsInsideOut) {
  const Mesh ball = ballMesh({0, 0, 0}, 5, 20), inward = ballMesh({0, 0, 0}, 5, 20, true);
  EXPECT_LT(compared(ball, inward).of_second.normals_agree, -0.99);
}

TEST(Comparison, IsTheSameOnAnyNumberOfThreads) {
  const Mesh a = ballMesh({0, 0, 0}, 5, 50), b = ballMesh({0.1, 0.05, 0}, 5.1, 43);
  const Comparison many = compared(a, b);
  Comparison one;
  tbb::task_arena(1).execute([&] { one = compared(a, b); });
  for (const auto& [x, y] : {std::pair(&many.of_first, &one.of_first), std::pair(&many.of_second, &one.of_second)}) {
    EXPECT_EQ(x->mean_mm, y->mean_mm);
    EXPECT_EQ(x->rms_mm, y->rms_mm);
    EXPECT_EQ(x->p95_mm, y->p95_mm);
    EXPECT_EQ(x->most.at, y->most.at);
    EXPECT_EQ(x->at_vertex, y->at_vertex);
    EXPECT_EQ(x->value, y->value);
  }
}

TEST(Comparison, IsCancelled) {
  const Mesh ball = ballMesh({0, 0, 0}, 5, 20);
  const MeshDistance d(ball);
  const auto out = compareMeshes(ball, d, ball, d, {}, [](double at, std::string_view) { return at < 0.6; });
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, Error::Code::kCancelled);
}

TEST(DeviationScale, IsGreyInTheBandAndTellsSidesApart) {
  const DeviationScale scale{0.1, 1};
  const auto grey = [](const Rgba8& c) { return c[0] == c[1] && c[1] == c[2]; };
  EXPECT_TRUE(grey(scale.colour(0.1)) && grey(scale.colour(-0.1)) && grey(scale.colour(0)));
  const Rgba8 over = scale.colour(0.11), under = scale.colour(-0.11), most = scale.colour(5);
  EXPECT_GT(over[0], over[2] + 80);
  EXPECT_GT(under[2], under[0] + 60);
  EXPECT_EQ(most, scale.colour(1));
  EXPECT_LT(most[0], over[0]) << "darker away from the band";
  EXPECT_FALSE(grey(scale.colour(std::nan(""))));

  const Comparison c = compared(ballMesh({0, 0, 0}, 5, 30), ballMesh({0, 0, 0}, 5.33, 30));
  EXPECT_DOUBLE_EQ(DeviationScale::of(c, 0.1).range_mm, 0.5);
  EXPECT_DOUBLE_EQ(DeviationScale::of(c, 1).range_mm, 2);
}

}  // namespace
}  // namespace kerf::comparison_test
