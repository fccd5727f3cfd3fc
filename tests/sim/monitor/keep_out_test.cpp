#include "sim/monitor/keep_out.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/tool/tool_file.h"
#include "sim/monitor/structures.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::keep_out_test {
namespace {

constexpr std::array kPulp = {Material::kPulp};

// A structure alone: an object entirely of pulp.
std::shared_ptr<const BakedObject> pulp(const std::function<double(const Vec3d&)>& distance, const Box3& box,
                                        double voxel) {
  auto baked = bakedFrom(distance, box, voxel, Material::kPulp);
  EXPECT_TRUE(baked) << baked.error().message();
  return *baked;
}
std::shared_ptr<const BakedObject> pulpBall(double radius, double voxel, const Vec3d& center) {
  Box3 box;
  box.add(center);
  box.grow(radius);
  return pulp([=](const Vec3d& p) { return (p - center).norm() - radius; }, box, voxel);
}
// A canal along an axis, 0.6 mm wide, with round ends.
double capsule(const Vec3d& p, const Vec3d& from, const Vec3d& to, double radius) {
  const double s = std::clamp((p - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
  return (p - from - s * (to - from)).norm() - radius;
}
std::shared_ptr<const KeepOut> keepOut(const BakedObject& object, const KeepOutOptions& options = {}) {
  auto made = KeepOut::make(object, kPulp, options);
  EXPECT_TRUE(made) << made.error().message();
  return *made;
}
// The same points on every machine: Halton's sequence.
double halton(int n, int base) {
  double f = 1, x = 0;
  for (; n > 0; n /= base) {
    f /= base;
    x += f * (n % base);
  }
  return x;
}
Vec3d pointIn(const Box3& box, int n) {
  return box.min + Vec3d(halton(n, 2), halton(n, 3), halton(n, 5)).cwiseProduct(box.size());
}

TEST(KeepOut, DistanceToASmallBallIsRightToHalfAVoxelOrSo) {
  for (const double voxel : {0.1, 0.05}) {
    const Vec3d center(0.013, -0.31, 0.222);
    const auto object = pulpBall(1, voxel, center);
    const auto field = keepOut(*object, {3, 0.5});
    Box3 box;
    box.add(center);
    box.grow(3);
    double worst = 0;
    for (int n = 1; n < 20000; ++n) {
      const Vec3d p = pointIn(box, n);
      const double exact = std::clamp((p - center).norm() - 1, -0.5, 3.0);
      worst = std::max(worst, std::abs(static_cast<double>(field->distance(p.cast<float>())) - exact));
    }
    // Half a voxel, plus the curvature of such a small ball beside its column of nodes.
    EXPECT_LE(worst, 0.55 * voxel) << voxel;
  }
}

TEST(KeepOut, DistanceToACanalIsRightToHalfAVoxel) {
  const Vec3d from(-5, -2, 1), to(6, 3, -1);
  Box3 box;
  box.add(from);
  box.add(to);
  box.grow(1.5);
  const auto object = pulp([&](const Vec3d& p) { return capsule(p, from, to, 1.5); }, box, 0.1);
  const auto field = keepOut(*object);
  EXPECT_EQ(field->spacing(), 0.1);
  box.grow(5);
  double worst = 0;
  for (int n = 1; n < 50000; ++n) {
    const Vec3d p = pointIn(box, n);
    const double exact = std::clamp(capsule(p, from, to, 1.5), -1.0, 5.0);
    worst = std::max(worst, std::abs(static_cast<double>(field->distance(p.cast<float>())) - exact));
  }
  EXPECT_LE(worst, 0.05);
}

// Distance of a ball to a ball, and of a ball to a canal: known exactly.
TEST(KeepOut, ToolsDistanceIsRightToHalfAVoxelAndItsSampling) {
  const double voxel = 0.1, r = 0.7;
  const ToolModel tool = practiceBall(r, 1);
  const ToolSamples samples(tool.cut);
  // Between samples, a ball's surface is nearer to a flat object by its sagitta.
  const double sagitta = samples.spacing() * samples.spacing() / (2 * r);
  EXPECT_LT(samples.spacing(), 0.25);

  const Vec3d from(-5, 0.03, 0), to(5, 0.4, 1);
  Box3 box;
  box.add(from);
  box.add(to);
  box.grow(1);
  const auto object = pulp([&](const Vec3d& p) { return capsule(p, from, to, 1); }, box, voxel);
  const auto field = keepOut(*object);
  box.grow(4);
  int near = 0;
  for (int n = 1; n < 3000; ++n) {
    const Rigid3 pose{Eigen::Quaterniond(Eigen::AngleAxisd(0.1 * n, Vec3d(1, 2, n % 7).normalized())), pointIn(box, n)};
    const double exact = capsule(pose * Vec3d(0, 0, r), from, to, 1) - r;
    if (exact < -0.9 || exact > 4.9) continue;
    ++near;
    const KeepOut::Reading reading = field->read(samples, pose);
    EXPECT_LE(reading.distance, exact + 0.5 * voxel + 2 * sagitta);
    EXPECT_GE(reading.distance, exact - 0.5 * voxel - 1e-3);
    EXPECT_FALSE(reading.is_far);
    EXPECT_NEAR((pose.inverse() * reading.point - Vec3d(0, 0, r)).norm(), r, 0.005) << "the point lies on the tool";
  }

  EXPECT_GT(near, 500);
}

TEST(KeepOut, SkippingGroupsLosesNothing) {
  const ToolModel tool = practiceBall(0.5, 1);
  const ToolSamples samples(tool.cut);
  const auto object = pulpBall(0.8, 0.1, Vec3d::Zero());
  const auto field = keepOut(*object);
  Box3 box;
  box.add(Vec3d::Zero());
  box.grow(5);
  for (int n = 1; n < 500; ++n) {
    const Rigid3 pose{Eigen::Quaterniond::Identity(), pointIn(box, n)};
    float least = 5;
    for (const Vec3f& p : samples.points())
      least = std::min(least, field->distance(p + pose.translation.cast<float>()));
    EXPECT_NEAR(field->read(samples, pose).distance, static_cast<double>(least), 1e-6);
  }
}

TEST(KeepOut, WhatIsFarIsFar) {
  const auto object = pulpBall(0.8, 0.1, Vec3d::Zero());
  const auto field = keepOut(*object);
  const ToolSamples samples(practiceBall(0.5, 1).cut);
  const KeepOut::Reading reading = field->read(samples, {Eigen::Quaterniond::Identity(), {0, 0, 30}});
  EXPECT_TRUE(reading.is_far);
  EXPECT_EQ(reading.distance, 5);
  EXPECT_EQ(field->distance(Vec3f::Constant(std::numeric_limits<float>::quiet_NaN())), 5);
  EXPECT_EQ(field->distance(Vec3f::Constant(1e30f)), 5);
}

TEST(KeepOut, LessMemoryIsCoarserAndNearlyAsExact) {
  const auto object = pulpBall(1, 0.1, Vec3d::Zero());
  const auto fine = keepOut(*object);
  KeepOutOptions options;
  options.most_bytes = fine->bytes() / 3;
  const auto coarse = keepOut(*object, options);
  EXPECT_EQ(coarse->spacing(), 0.2);
  EXPECT_LE(coarse->bytes(), options.most_bytes);
  Box3 box;
  box.add(Vec3d::Zero());
  box.grow(4);
  for (int n = 1; n < 5000; ++n) {
    const Vec3d p = pointIn(box, n);
    if (p.norm() < 1) continue;
    EXPECT_NEAR(static_cast<double>(coarse->distance(p.cast<float>())), std::min(5.0, p.norm() - 1), 0.1);
  }
}

TEST(KeepOut, TheRimOfACylinderIsSampled) {
  RevolvedProfile profile;
  profile.lineTo(0.5, 0).lineTo(0.5, 3).close();
  const ToolField cut{RevolvedShape(profile)};
  const ToolSamples samples(cut);
  EXPECT_EQ(samples.points().size(), 400u);
  int on_rim = 0;
  for (const Vec3f& p : samples.points()) {
    EXPECT_LT(std::abs(cut.distance(p)), 0.006f);
    on_rim += std::hypot(p[0], p[1]) > 0.49f && p[2] < 0.01f;
  }
  EXPECT_GE(on_rim, 8);
}

TEST(KeepOut, WhatIsNotThereIsRefused) {
  const auto object = pulpBall(1, 0.1, Vec3d::Zero());
  const std::array nerve = {Material::kNerveCanal};
  const auto none = KeepOut::make(*object, nerve);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Error::Code::kNotFound);
  for (const double bad : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(KeepOut::make(*object, kPulp, {bad, 1}));
  }
  EXPECT_FALSE(KeepOut::make(*object, kPulp, {5, 1, 100})) << "no room at all";
}

TEST(KeepOut, CanBeCancelled) {
  const auto object = pulpBall(1, 0.1, Vec3d::Zero());
  int reports = 0;
  const auto stop = [&reports](double, std::string_view) { return ++reports < 1; };
  const auto made = KeepOut::ofSolid(*object, {}, stop);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Error::Code::kCancelled);
  EXPECT_EQ(reports, 1);
}

TEST(Structures, SayHowFarTheyAreMeasured) {
  for (const double voxel : {0.1, 0.01}) {
    const auto object = pulpBall(voxel < 0.05 ? 0.1 : 1, voxel, Vec3d::Zero());
    const auto made = Structures::of(*object);
    ASSERT_TRUE(made) << made.error().message();
    EXPECT_NEAR((*made)->reach(), std::min(5.0, KeepOut::kMostVoxels * voxel), 1e-6);
    EXPECT_EQ((*made)->distance({40, 0, 0}), (*made)->reach());
    EXPECT_NEAR((*made)->distance({voxel < 0.05 ? 1.1 : 3, 0, 0}), voxel < 0.05 ? 1 : 2, voxel);
  }
}

TEST(KeepOut, ReadsWithoutAllocating) {
  const auto object = pulpBall(1, 0.1, Vec3d::Zero());
  const auto field = keepOut(*object);
  const ToolSamples samples(practiceBall(0.5, 1).cut);
  const AllocationGuard guard;
  for (int n = 0; n < 100; ++n) field->read(samples, {Eigen::Quaterniond::Identity(), {0, 0, 0.05 * n}});
}

}  // namespace
}  // namespace kerf::keep_out_test
