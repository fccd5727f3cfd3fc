// Laws for every input, tried on random ones (RapidCheck shrinks failures to the smallest case).
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "geometry/field/marching_cubes.h"
#include "geometry/tool/sweep.h"
#include "tests/geometry/sampled_field.h"

namespace kerf::properties_test {
namespace {

double real(double low, double high) {
  return low + (high - low) * static_cast<double>(*rc::gen::inRange(0, 1'000'001)) * 1e-6;
}
Vec3d point(double size) {
  const double x = real(-size, size), y = real(-size, size), z = real(-size, size);
  return {x, y, z};
}
Rigid3 pose(double size, double angle) {
  Vec3d axis = point(1);
  if (axis.norm() < 1e-3) axis = Vec3d::UnitX();
  const double turn = real(-angle, angle);
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn, axis.normalized())), point(size)};
}
RevolvedShape taper() {
  const double bottom = real(0.1, 1), top = real(0.1, 1), height = real(0.2, 4);
  RevolvedProfile p(0);
  p.lineTo(bottom, 0).lineTo(top, height).close();
  return RevolvedShape(p);
}

RC_GTEST_PROP(ShapeProperty, DistanceIsOneLipschitz, ()) {
  const RevolvedShape shape = taper();
  const Vec3d a = point(4), b = a + point(0.5);
  RC_ASSERT(std::abs(shape.distance(a) - shape.distance(b)) <= (a - b).norm() + 1e-12);
}

RC_GTEST_PROP(SweepProperty, IsTheMinimumOverThePosesBetween, ()) {
  const RevolvedShape shape = taper();
  const Rigid3 from = pose(3, 3), to = from * pose(2, 1);
  const SweptTool sweep(shape, from, to);
  const Vec3d x = point(5);
  const double tolerance = 1e-4, d = sweep.distance(x, 1e9, tolerance);
  double sampled = 1e9;
  for (int n = 0; n <= 400; ++n) {
    const double s = n / 400.0;
    const Rigid3 T{from.rotation.slerp(s, to.rotation), from.translation + s * (to.translation - from.translation)};
    sampled = std::min(sampled, shape.distance(T.inverse() * x));
  }
  RC_ASSERT(d <= sampled + tolerance + 1e-9);
  const double reach = (to.translation - from.translation).norm() + 1.0 * 8;  // the maximum speed per unit of s
  RC_ASSERT(d >= sampled - reach / 800);
}

RC_GTEST_PROP(SweepProperty, CuttingOffFarPointsNeverHidesNearOnes, ()) {
  const RevolvedShape shape = taper();
  const Rigid3 from = pose(2, 3), to = from * pose(1, 0.5);
  const SweptTool sweep(shape, from, to);
  const Vec3d x = point(4);
  const double cutoff = real(0.01, 1), full = sweep.distance(x, 1e9, 1e-4), cut = sweep.distance(x, cutoff, 1e-4);
  const bool agrees = full < cutoff - 1e-3 ? std::abs(cut - full) < 2.1e-4 : cut >= std::min(full, cutoff) - 2.1e-4;
  RC_ASSERT(agrees);
  const double radius = real(0.01, 1);
  const Vec3d inside = x + radius * point(0.57);
  RC_ASSERT(sweep.mayReach(x, radius, cutoff) || sweep.distance(inside, 1e9, 1e-4) >= cutoff - 1e-9);
}

RC_GTEST_PROP(MarchingCubesProperty, AnyFieldGivesAClosedSurface, ()) {
  BrickField field(0.1, 0.4f);
  for (int n = 0; n < 27; ++n) field.touch({n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1});
  BrickValues& v = field.brick(static_cast<std::size_t>(field.find({0, 0, 0})));
  const auto values = *rc::gen::container<std::vector<int>>(kBrickNodes, rc::gen::inRange(-1000, 1001));
  for (std::size_t n = 0; n < kBrickNodes; ++n) v[n] = static_cast<float>(values[n]) * 1e-4f;
  const Mesh mesh = marchingCubes(field);
  expectClosedManifold(mesh);
  RC_ASSERT(!::testing::Test::HasFailure());
}

}  // namespace
}  // namespace kerf::properties_test
