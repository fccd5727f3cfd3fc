#include "geometry/tool/sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace kerf::sweep_test {
namespace {

constexpr double kNever = 1e9, kTolerance = 1e-5;

struct Random {
  std::mt19937 engine{5};
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vec3d point(double reach) { return {(*this)(-reach, reach), (*this)(-reach, reach), (*this)(-reach, reach)}; }
  Rigid3 pose(double reach, double angle) {
    return {Eigen::Quaterniond(Eigen::AngleAxisd((*this)(0, angle), point(1).normalized())), point(reach)};
  }
};

const RevolvedShape& ball() {
  static const RevolvedShape shape(RevolvedProfile().arcTo({0, 0.7}, {0, 1.4}));
  return shape;
}
const RevolvedShape& taper() {
  static const RevolvedShape shape(RevolvedProfile().lineTo(0.4, 0).lineTo(0.8, 3).close());
  return shape;
}

Rigid3 between(const Rigid3& a, const Rigid3& b, double s) {
  return {a.rotation.slerp(s, b.rotation), a.translation + s * (b.translation - a.translation)};
}

TEST(Sweep, BallOnALineIsACapsule) {
  Random random;
  for (int n = 0; n < 2000; ++n) {
    const Vec3d a = random.point(2), b = random.point(2), x = random.point(4), ab = b - a;
    const Vec3d up(0, 0, 0.7);
    const double t = std::clamp((x - up - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
    const double exact = (x - up - a - t * ab).norm() - 0.7;
    const double d = SweptTool(ball(), {Eigen::Quaterniond::Identity(), a}, {Eigen::Quaterniond::Identity(), b})
                         .distance(x, kNever, kTolerance);
    EXPECT_GE(d, exact - 1e-9);
    EXPECT_LE(d, exact + kTolerance + 1e-9);
  }
}

TEST(Sweep, BallTurnedAboutItsTipIsASectionOfATorus) {
  // The tip stays. The centre, 0.7 mm away, moves on a circle in the xz plane by 100 degrees.
  const double angle = 100 * std::numbers::pi / 180;
  const SweptTool sweep(ball(), {}, {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3d::UnitY())), Vec3d::Zero()});
  Random random;
  for (int n = 0; n < 2000; ++n) {
    const Vec3d x = random.point(3);
    const double at = std::atan2(x[0], x[2]);  // 0 along +z, growing towards +x
    double to_circle;
    if (at >= 0 && at <= angle) {
      to_circle = std::hypot(std::hypot(x[0], x[2]) - 0.7, x[1]);
    } else {
      to_circle =
          std::min((x - Vec3d(0, 0, 0.7)).norm(), (x - 0.7 * Vec3d(std::sin(angle), 0, std::cos(angle))).norm());
    }
    EXPECT_NEAR(sweep.distance(x, kNever, kTolerance), to_circle - 0.7, kTolerance + 1e-9);
  }
}

TEST(Sweep, DoesNotDependOnHowAMotionIsDivided) {
  Random random;
  for (int round = 0; round < 20; ++round) {
    const Rigid3 from = random.pose(1, 1), to = random.pose(1, 1);
    const Vec3d x = random.point(4);
    std::vector<double> found;
    for (const int parts : {1, 10, 100}) {
      double best = kNever;
      for (int n = 0; n < parts; ++n)
        best = std::min(
            best, SweptTool(taper(), between(from, to, n / double(parts)), between(from, to, (n + 1) / double(parts)))
                      .distance(x, kNever, kTolerance));
      found.push_back(best);
    }
    EXPECT_NEAR(found[0], found[1], kTolerance + 1e-9);
    EXPECT_NEAR(found[0], found[2], kTolerance + 1e-9);
  }
}

TEST(Sweep, IsTheMinimumOverManyPoses) {
  Random random;
  for (int round = 0; round < 100; ++round) {
    const Rigid3 from = random.pose(2, 2), to = random.pose(2, 2);
    const Vec3d x = random.point(4);
    double sampled = kNever;
    for (int n = 0; n <= 2000; ++n)
      sampled = std::min(sampled, taper().distance(between(from, to, n / 2000.0).inverse() * x));
    const double d = SweptTool(taper(), from, to).distance(x, kNever, kTolerance);
    EXPECT_LE(d, sampled + kTolerance + 1e-9);
    EXPECT_GE(d, sampled - 0.01);  // at most 15 mm of path in 2000 steps
  }
}

TEST(Sweep, CutoffAndFloorOnlyLoosenWhatTheyMay) {
  Random random;
  for (int n = 0; n < 1000; ++n) {
    const SweptTool sweep(taper(), random.pose(2, 2), random.pose(2, 2));
    const Vec3d x = random.point(4);
    const double cutoff = random(0, 1), floor = random(-0.4, 0);
    const double exact = sweep.distance(x, kNever, kTolerance), d = sweep.distance(x, cutoff, kTolerance, floor);
    if (exact >= cutoff)
      EXPECT_GE(d, cutoff - kTolerance);
    else if (exact > floor)
      EXPECT_NEAR(d, exact, 2 * kTolerance);
    else
      EXPECT_LE(d, floor + kTolerance);
  }
}

TEST(Sweep, MayReachAndBoundsMissNothing) {
  Random random;
  int near = 0, far = 0;
  for (int n = 0; n < 6000; ++n) {
    const SweptTool sweep(taper(), random.pose(2, 2), random.pose(2, 2));
    const Vec3d center = random.point(4);
    const double radius = random(0.05, 0.5), cutoff = random(0, 0.5);
    const Vec3d x = center + radius * random(0, 1) * random.point(1).normalized();
    const double d = sweep.distance(x, kNever, kTolerance);
    const bool reaches = sweep.mayReach(center, radius, cutoff);
    (reaches ? near : far) += 1;
    if (d < cutoff - kTolerance) {
      EXPECT_TRUE(reaches);
    }
    if (d < 0) {
      EXPECT_TRUE(sweep.bounds().contains(x));
    }
  }
  EXPECT_GT(near, 100);
  EXPECT_GT(far, 100);
}

}  // namespace
}  // namespace kerf::sweep_test
