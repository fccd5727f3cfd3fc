// Removed volume and surface against the geometric sweep of a tool: shapes x motions x resolutions, all step lengths
// and grid rotations. A convex body of volume V that moves by L without turning sweeps V + A L, with A its area
// projected along the motion.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>

#include "geometry/field/marching_cubes.h"
#include "sim/run/sweep/sweep_cutter.h"

namespace kerf::sweep_accuracy_test {
namespace {

constexpr double kPi = std::numbers::pi;

// A field of tissue wherever the sweep goes.
BrickField solidAround(const Box3& region, double h) {
  BrickField phi0(h, static_cast<float>(3 * h), static_cast<float>(-4 * h));
  const Vec3i low = brickOf((region.min / h).array().floor().cast<int>().matrix()) - Vec3i::Constant(2);
  const Vec3i high = brickOf((region.max / h).array().ceil().cast<int>().matrix()) + Vec3i::Constant(2);
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) phi0.markInterior({x, y, z});
  return phi0;
}

using Motion = std::function<Rigid3(double)>;  // pose at s in [0, 1]

Mesh swept(const ToolShape& shape, const Motion& motion, int steps, double h, BrickField* field = nullptr) {
  Box3 region;
  for (int n = 0; n < steps; ++n)
    region.add(SweptTool(shape, motion(n / double(steps)), motion((n + 1) / double(steps))).bounds());
  const BrickField phi0 = solidAround(region, h);
  SweepCutter cutter(phi0);
  for (int n = 0; n < steps; ++n)
    cutter.advance(SweptTool(shape, motion(n / double(steps)), motion((n + 1) / double(steps))));
  if (field) *field = cutter.sweep();
  return marchingCubes(cutter.sweep());
}

// An attitude and offset without any alignment.
Rigid3 odd(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> n;
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  Eigen::Quaterniond q(n(random), n(random), n(random), n(random));
  return {q.normalized(), Vec3d(u(random), u(random), u(random))};
}

Motion straight(const Rigid3& base, const Vec3d& travel) {
  return [base, travel](double s) { return base * Rigid3{Eigen::Quaterniond::Identity(), s * travel}; };
}

struct Case {
  const char* name;
  std::shared_ptr<const ToolShape> shape;
  Vec3d travel;   // tool frame, mm
  double volume;  // mm^3, swept
  double radius;  // mm, the size to compare with the voxel
};

RevolvedProfile ball(double r) {
  RevolvedProfile p(0);
  p.arcTo({0, r}, {0, 2 * r});
  return p;
}
RevolvedProfile cylinder(double r, double height) {
  RevolvedProfile p(0);
  p.lineTo(r, 0).lineTo(r, height).close();
  return p;
}
RevolvedProfile cone(double r, double height) {
  RevolvedProfile p(0);
  p.lineTo(r, height).close();
  return p;
}

std::vector<Case> straightCases() {
  const double r = 0.8, H = 3, L = 2.5;
  Box3 blade;
  blade.add(Vec3d(0, -r, 0));
  blade.add(Vec3d(2, r, 6));  // half thickness 0.8
  const auto revolved = [](RevolvedProfile p) { return std::make_shared<RevolvedShape>(std::move(p)); };
  return {
      {"ball", revolved(ball(r)), {L, 0, 0}, 4.0 / 3 * kPi * r * r * r + kPi * r * r * L, r},
      {"ball, slanted",
       revolved(ball(r)),
       {L / 3, 2 * L / 3, 2 * L / 3},
       4.0 / 3 * kPi * r * r * r + kPi * r * r * L,
       r},
      {"cylinder along", revolved(cylinder(r, H)), {0, 0, L}, kPi * r * r * (H + L), r},
      {"cylinder across", revolved(cylinder(r, H)), {L, 0, 0}, kPi * r * r * H + 2 * r * H * L, r},
      {"cone across", revolved(cone(1.6 * r, H)), {L, 0, 0}, kPi * 2.56 * r * r * H / 3 + 1.6 * r * H * L, 1.6 * r},
      {"blade edge first", std::make_shared<BoxShape>(blade), {-L, 0, 0}, 2 * r * 6 * (2 + L), r},
  };
}

TEST(SweepAccuracy, StraightSweepsRemoveTheAnalyticVolume) {
  for (const auto& [voxels, tolerance] : {std::pair{5.0, 0.01}, {10.0, 0.005}, {20.0, 0.005}})
    for (const Case& c : straightCases()) {
      const double h = c.radius / voxels;
      const double volume = signedVolume(swept(*c.shape, straight(odd(1), c.travel), 3, h));
      EXPECT_NEAR(volume / c.volume, 1.0, tolerance) << c.name << ", " << voxels << " voxels";
      RecordProperty(std::string(c.name) + " " + std::to_string(static_cast<int>(voxels)) + " voxels, error %",
                     std::to_string(100 * (volume / c.volume - 1)));
      std::printf("  %-18s radius %4.0f voxels: volume error %+.3f %%\n", c.name, voxels,
                  100 * (volume / c.volume - 1));
    }
}

// A ball rotated about a pivot beside it sweeps a section of a torus.
TEST(SweepAccuracy, TurningBallRemovesATorusSection) {
  const double r = 0.8, ring = 2.5, angle = 1.2;
  const RevolvedShape shape(ball(r));
  const double exact = kPi * r * r * ring * angle + 4.0 / 3 * kPi * r * r * r;
  const Rigid3 base = odd(2);
  // The pivot lies at (-ring, 0, r) of the tool's frame. The rotation is about its y, so tip and attitude both change.
  const Motion motion = [&](double s) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(s * angle, Vec3d::UnitY()));
    const Vec3d pivot(-ring, 0, r);
    return base * Rigid3{turn, pivot - turn * pivot};
  };
  for (const auto& [voxels, tolerance] : {std::pair{5.0, 0.01}, {10.0, 0.005}}) {
    const double volume = signedVolume(swept(shape, motion, 120, r / voxels));
    std::printf("  torus section      radius %4.0f voxels: volume error %+.3f %%\n", voxels,
                100 * (volume / exact - 1));
    EXPECT_NEAR(volume / exact, 1.0, tolerance);
  }
}

// A blade rotated about its own corner, in its own plane. In polar coordinates about the corner, the outline is the
// maximum radius that has passed each direction.
TEST(SweepAccuracy, TurningBladeRemovesItsFan) {
  const double half = 0.4, width = 2, length = 5, angle = 0.6;
  Box3 box;
  box.add(Vec3d(0, -half, 0));
  box.add(Vec3d(width, half, length));
  const BoxShape shape(box);
  double area = 0;
  const int n = 200000;
  const auto reach = [&](double a) {
    return a < 0 || a > kPi / 2 ? 0.0 : std::min(length / std::cos(a), width / std::sin(std::max(a, 1e-12)));
  };
  const double corner = std::atan2(width, length);  // direction of the far corner, from +z towards +x
  for (int i = 0; i < n; ++i) {
    const double a = (i + 0.5) / n * (kPi / 2 + angle), low = a - angle;
    const double widest = low <= corner && corner <= a ? std::hypot(width, length) : std::max(reach(low), reach(a));
    area += 0.5 * widest * widest * (kPi / 2 + angle) / n;
  }
  const double exact = area * 2 * half;
  const Rigid3 base = odd(3);
  const Motion motion = [&](double s) {
    return base * Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(s * angle, Vec3d::UnitY())), Vec3d::Zero()};
  };
  for (const auto& [voxels, tolerance] : {std::pair{5.0, 0.01}, {10.0, 0.005}}) {
    const double volume = signedVolume(swept(shape, motion, 1, half / voxels));
    std::printf("  fan of the blade   half thickness %2.0f voxels: volume error %+.3f %%\n", voxels,
                100 * (volume / exact - 1));
    EXPECT_NEAR(volume / exact, 1.0, tolerance);
  }
}

TEST(SweepAccuracy, StepLengthsOverTwoDecadesGiveTheSameVolume) {
  const double r = 0.7;
  const RevolvedShape shape(ball(r));
  const Rigid3 base = odd(4);
  const Motion motion = [&](double s) {  // translating and rotating
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.8 * s, Vec3d(1, 2, 0.5).normalized()));
    return base * Rigid3{turn, Vec3d(3 * s, 0.4 * s, 0)};
  };
  const double fine = signedVolume(swept(shape, motion, 400, 0.1));
  for (const int steps : {4, 12, 40, 120}) {
    const double volume = signedVolume(swept(shape, motion, steps, 0.1));
    std::printf("  %3d steps: %+.4f %% of 400 steps\n", steps, 100 * (volume / fine - 1));
    EXPECT_NEAR(volume / fine, 1.0, 0.005) << steps;
  }
}

TEST(SweepAccuracy, TwentyFourGridRotationsGiveTheSameVolume) {
  const Case c = straightCases()[3];  // the cylinder across has a curved side, flat ends and sharp edges
  double low = 1e9, high = 0;
  for (unsigned seed = 100; seed < 124; ++seed) {
    const double volume = signedVolume(swept(*c.shape, straight(odd(seed), c.travel), 2, c.radius / 8));
    low = std::min(low, volume);
    high = std::max(high, volume);
    EXPECT_NEAR(volume / c.volume, 1.0, 0.005) << seed;
  }
  std::printf("  spread over 24 rotations: %.3f %%\n", 100 * (high - low) / c.volume);
  EXPECT_LT((high - low) / c.volume, 0.005);
}

// Distance from a point to a triangle, after Ericson, Real-Time Collision Detection, 2005, 5.1.5.
double distanceToTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.norm();
  const Vec3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.norm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).norm();
  const Vec3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.norm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).norm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).norm();
  const Vec3d n = ab.cross(ac);
  return std::abs(n.dot(ap)) / n.norm();
}

// Surface: mesh to truth at vertices and centroids, truth to mesh at their projections onto the truth.
TEST(SweepAccuracy, SurfaceLiesWithinAVoxelEverywhereAndAFractionOfItOnAverage) {
  for (const Case& c : straightCases()) {
    const double h = c.radius / 8;
    const Motion motion = straight(odd(5), c.travel);
    const Mesh mesh = swept(*c.shape, motion, 5, h);
    const SweptTool truth(*c.shape, motion(0), motion(1));
    const auto distance = [&](const Vec3d& p) { return truth.distance(p, 1e9, 1e-7); };
    double squares = 0, worst = 0;
    for (const Vec3d& p : mesh.vertices) {
      const double d = distance(p) / h;
      squares += d * d;
      worst = std::max(worst, std::abs(d));
    }
    const double rms = std::sqrt(squares / static_cast<double>(mesh.vertices.size()));
    // The reverse: from points of the true surface, with edges and corners of the tool, to the nearest triangle.
    double back = 0;
    std::mt19937 random(11);
    std::uniform_int_distribution<std::size_t> any(0, mesh.vertices.size() - 1);
    std::normal_distribution<double> jitter(0, 0.7 * h);
    for (int n = 0; n < 300; ++n) {
      Vec3d p = mesh.vertices[any(random)] + Vec3d(jitter(random), jitter(random), jitter(random));
      for (int step = 0; step < 30; ++step) {  // walk to the true surface along the numeric gradient
        const double d = distance(p), e = 1e-5;
        if (std::abs(d) < 1e-6) break;
        const Vec3d g = Vec3d(distance(p + Vec3d(e, 0, 0)) - d, distance(p + Vec3d(0, e, 0)) - d,
                              distance(p + Vec3d(0, 0, e)) - d) /
                        e;
        p -= d * g / std::max(0.5, g.squaredNorm());
      }
      if (std::abs(distance(p)) > 1e-3 * h) continue;
      double nearest = 1e9;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if ((mesh.corner(t, 0) - p).squaredNorm() > 9 * h * h) continue;
        nearest = std::min(nearest, distanceToTriangle(p, mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)));
      }
      back = std::max(back, nearest / h);
    }
    std::printf("  %-18s rms %.3f, mesh to truth %.3f, truth to mesh %.3f voxels\n", c.name, rms, worst, back);
    EXPECT_LE(rms, 0.15) << c.name;
    EXPECT_LE(worst, 1.0) << c.name;
    EXPECT_LE(back, 1.0) << c.name;
  }
}

TEST(SweepCutter, NothingIsAddedAndTheOrderOfMotionsDoesNotMatter) {
  const RevolvedShape shape(ball(0.7));
  Box3 region;
  region.add(Vec3d(-3, -3, -3));
  region.add(Vec3d(3, 3, 3));
  const BrickField phi0 = solidAround(region, 0.1);
  const Rigid3 a = odd(7), b = odd(8), c = odd(9);
  SweepCutter one(phi0), other(phi0);
  one.advance(SweptTool(shape, a, b));
  one.advance(SweptTool(shape, b, c));
  other.advance(SweptTool(shape, b, c));
  other.advance(SweptTool(shape, a, b));
  const BrickField cut = one.cutField();
  ASSERT_FALSE(cut.isEmpty());
  for (std::size_t i = 0; i < cut.brickCount(); ++i)
    for (const float v : cut.brick(i)) EXPECT_GE(v, phi0.interior());
  const double first = signedVolume(marchingCubes(one.sweep())), second = signedVolume(marchingCubes(other.sweep()));
  EXPECT_NEAR(first / second, 1.0, 1e-4);  // the branch and bound's tolerance
}

}  // namespace
}  // namespace kerf::sweep_accuracy_test
