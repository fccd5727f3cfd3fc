#include "geometry/tool/tool_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kerf::tool_shape_test {
namespace {

struct Random {
  std::mt19937 engine{11};
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vec3d point(double reach) { return {(*this)(-reach, reach), (*this)(-reach, reach), (*this)(-reach, reach)}; }
};

std::vector<std::shared_ptr<const ToolShape>> shapes() {
  const auto ball = std::make_shared<RevolvedShape>(RevolvedProfile().arcTo({0, 0.7}, {0, 1.4}));
  const auto taper = std::make_shared<RevolvedShape>(RevolvedProfile().lineTo(0.4, 0).lineTo(0.8, 3).close());
  const auto box = std::make_shared<BoxShape>(Box3{Vec3d(0, -0.2, -1), Vec3d(0.5, 0.2, 2)});
  const auto rounded = std::make_shared<BoxShape>(Box3{Vec3d(0, -0.2, -1), Vec3d(0.5, 0.2, 2)}, 0.1);
  RevolvedProfile waisted;  // a rounded edge, a hollow, a step
  waisted.lineTo(0.3, 0).arcTo({0.3, 0.3}, {0.6, 0.3}).hollowArcTo({0.6, 0.8}, {0.6, 1.3});
  waisted.lineTo(0.9, 1.3).lineTo(0.5, 2).close();
  const auto hollow = std::make_shared<RevolvedShape>(waisted);
  const auto part = std::make_shared<RevolvedShape>(waisted.clipped(0.2, 1.1));
  const auto flat = std::make_shared<ExtrudedShape>(waisted, 0.4);
  return {
      ball,   taper, box,  rounded,
      hollow, part,  flat, std::make_shared<UnionShape>(std::vector<std::shared_ptr<const ToolShape>>{ball, taper})};
}

TEST(ToolShape, BallIsItsFormula) {
  const RevolvedShape ball(RevolvedProfile().arcTo({0, 0.7}, {0, 1.4}));
  Random random;
  for (int n = 0; n < 2000; ++n) {
    const Vec3d p = random.point(3);
    EXPECT_NEAR(ball.distance(p), (p - Vec3d(0, 0, 0.7)).norm() - 0.7, 1e-12);
  }
}

TEST(ToolShape, FrustumMatchesTheNearestOfManySurfacePoints) {
  const RevolvedShape frustum(RevolvedProfile().lineTo(0.4, 0).lineTo(0.8, 3).close());
  Random random;
  for (int n = 0; n < 300; ++n) {
    const Vec3d p = random.point(3);
    const Eigen::Vector2d q(std::hypot(p[0], p[1]), p[2]);
    double nearest = 1e9;
    for (int i = 0; i <= 3000; ++i) {
      const double t = i / 3000.0;
      nearest = std::min({nearest, (q - Eigen::Vector2d(0.4 * t, 0)).norm(), (q - Eigen::Vector2d(0.8 * t, 3)).norm(),
                          (q - Eigen::Vector2d(0.4 + 0.4 * t, 3 * t)).norm()});
    }
    const bool inside = q[1] > 0 && q[1] < 3 && q[0] < 0.4 + 0.4 * q[1] / 3;
    EXPECT_NEAR(frustum.distance(p), inside ? -nearest : nearest,
                1.1e-3);  // sample spacing 1 um, corner case 1 mm / 1000
  }
}

TEST(ToolShape, BoxIsItsFormula) {
  const BoxShape box(Box3{Vec3d(0, -0.2, -1), Vec3d(0.5, 0.2, 2)});
  EXPECT_NEAR(box.distance({0.25, 0, 0}), -0.2, 1e-12);
  EXPECT_NEAR(box.distance({0.8, 0.6, 0}), 0.5, 1e-12);
  EXPECT_NEAR(box.distance({-0.1, 0, 0}), 0.1, 1e-12);
  EXPECT_NEAR(box.distance({0.5, 0.2, 2}), 0, 1e-12);
}

TEST(ToolShape, DistanceNeverGrowsFasterThanTheWay) {
  Random random;
  for (const auto& shape : shapes())
    for (int n = 0; n < 4000; ++n) {
      const Vec3d a = random.point(2), b = a + random.point(n % 2 ? 1.0 : 0.01);
      EXPECT_LE(std::abs(shape->distance(a) - shape->distance(b)), (a - b).norm() + 1e-12);
    }
}

TEST(ToolShape, AClippedOutlineIsTheSolidBetweenTwoHeights) {
  RevolvedProfile outline;
  outline.lineTo(0.3, 0).arcTo({0.3, 0.3}, {0.6, 0.3}).hollowArcTo({0.6, 0.8}, {0.6, 1.3});
  outline.lineTo(0.9, 1.3).lineTo(0.5, 2).close();
  const RevolvedShape whole(outline);
  Random random;
  for (const auto& [low, high] : {std::pair{0.0, 0.1}, {0.2, 1.0}, {0.3, 1.3}, {0.9, 2.0}, {1.3, 1.7}}) {
    const RevolvedShape part(outline.clipped(low, high));
    for (int n = 0; n < 2000; ++n) {
      const Vec3d p = random.point(2);
      if (std::abs(p[2] - low) < 1e-9 || std::abs(p[2] - high) < 1e-9) continue;
      EXPECT_EQ(part.distance(p) < 0, whole.distance(p) < 0 && p[2] > low && p[2] < high)
          << low << " " << p.transpose();
    }
  }
}

TEST(ToolShape, HighestAsWideAsIsWhereTheOutlineNarrowsToIt) {
  EXPECT_NEAR(RevolvedProfile().arcTo({0, 1}, {0, 2}).highestAsWideAs(0.6), 1.8, 1e-12);
  EXPECT_NEAR(RevolvedProfile().lineTo(1, 0).lineTo(0.5, 2).close().highestAsWideAs(0.75), 1, 1e-12);
  EXPECT_NEAR(RevolvedProfile().lineTo(1, 0).lineTo(0.5, 2).close().highestAsWideAs(0.4), 2, 1e-12);
  EXPECT_NEAR(RevolvedProfile().lineTo(1, 0).lineTo(0.5, 2).close().highestAsWideAs(3), 0, 1e-12);
}

TEST(ToolShape, BoundsHoldEverythingInside) {
  Random random;
  for (const auto& shape : shapes())
    for (int n = 0; n < 4000; ++n)
      if (const Vec3d p = random.point(3); shape->distance(p) < 0) {
        EXPECT_TRUE(shape->bounds().contains(p));
      }
}

}  // namespace
}  // namespace kerf::tool_shape_test
