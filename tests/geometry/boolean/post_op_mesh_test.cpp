#include "geometry/boolean/post_op_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "geometry/boolean/removed_solid.h"
#include "geometry/mesh/crossing_pairs.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/geometry/sampled_field.h"
#include "tests/support/open_block.h"

namespace kerf::post_op_mesh_test {
namespace {

constexpr double kRadius = 3.0;

struct CutBall {
  Mesh source = ballMesh(Vec3d::Zero(), kRadius, 48);
  double h = 0.1, tool = 0.7;
  Vec3d center{0.3, 0.2, 2.9};
  BrickField rho;
  CutBall() {
    Box3 box;
    box.add(Vec3d::Zero());
    box.grow(kRadius);
    const BrickField phi0 = sampled(h, box, [](const Vec3d& p) { return p.norm() - kRadius; });
    const BrickField sweep = sampled(h, box, [&](const Vec3d& p) { return (p - center).norm() - tool; });
    rho = removedFieldFromSweep(phi0, sweep);
  }
};

TEST(PostOpMesh, FarVerticesAreTheSourcesOwnBitForBitAndInOrder) {
  const CutBall c;
  const auto out = postOperativeMesh(c.source, c.rho);
  ASSERT_TRUE(out) << out.error().message();
  std::size_t expected = 0, at = 0;
  for (const Vec3d& p : c.source.vertices) {
    if ((p - c.center).norm() <= c.tool + 2 * c.h) continue;
    ++expected;
    while (at < out->mesh.vertices.size() && out->mesh.vertices[at] != p) ++at;
    ASSERT_LT(at, out->mesh.vertices.size()) << "a far vertex is missing or out of order";
    EXPECT_TRUE(out->is_source[at]);
  }
  EXPECT_GT(expected, c.source.vertices.size() / 2);
}

TEST(PostOpMesh, ResultIsClosedFreeOfCrossingsAndRepresentableInFloat32) {
  const CutBall c;
  const auto out = postOperativeMesh(c.source, c.rho);
  ASSERT_TRUE(out) << out.error().message();
  expectClosedManifold(out->mesh);
  EXPECT_TRUE(crossingPairs(out->mesh).empty());
  for (const Vec3d& p : out->mesh.vertices) EXPECT_EQ(p, Vec3d(roundedToFloat(p)));
  EXPECT_EQ(out->report.pieces, 1u);
}

TEST(PostOpMesh, RemovedVolumeIsTheLensOfTwoBalls) {
  const CutBall c;
  const auto out = postOperativeMesh(c.source, c.rho);
  ASSERT_TRUE(out) << out.error().message();
  const double R = kRadius, r = c.tool, d = c.center.norm();
  const double lens = std::numbers::pi * std::pow(R + r - d, 2) *
                      (d * d + 2 * d * r - 3 * r * r + 2 * d * R + 6 * r * R - 3 * R * R) / (12 * d);
  EXPECT_NEAR(out->report.removed_volume_mm3 / lens, 1.0, 0.01);  // the source's own facets lose 0.3 %
}

TEST(PostOpMesh, AnyCutsFieldGivesTheSameVolumeToAPercent) {
  CutBall c;
  Box3 box;
  box.add(Vec3d::Zero());
  box.grow(kRadius);
  const BrickField phi0 = sampled(c.h, box, [](const Vec3d& p) { return p.norm() - kRadius; });
  const BrickField phi =
      sampled(c.h, box, [&](const Vec3d& p) { return std::max(p.norm() - kRadius, c.tool - (p - c.center).norm()); });
  const auto by_sweep = postOperativeMesh(c.source, c.rho),
             by_cut = postOperativeMesh(c.source, removedFieldFromCut(phi0, phi));
  ASSERT_TRUE(by_sweep && by_cut);
  EXPECT_NEAR(by_cut->report.removed_volume_mm3 / by_sweep->report.removed_volume_mm3, 1.0, 0.03);
}

// A block askew to the grid, and a ball that moves along its top.
struct BallAlongABlock {
  static constexpr double kLong = 1.5;
  double h, radius;
  Mesh source;
  BrickField phi0, ball;

  // @param height  of the ball's middle above the top.   @param up  of the top above a layer of nodes.
  BallAlongABlock(double voxel, double ball_radius, double height, double tilt, double up)
      : h(voxel), radius(ball_radius) {
    const Vec3d size(4, 3, 1.5), half = 0.5 * size, middle(0, 0, -half[2]);
    const Rigid3 pose{Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Vec3d(0.4, 0.8, 0.45).normalized())),
                      Vec3d(0.013, 0.027, up)};
    const Rigid3 back = pose.inverse();
    source = test::blockMesh(true, size);
    for (Vec3d& v : source.vertices) v = roundedToFloat(Vec3d(pose * v));
    phi0 = sampled(h, bounds(source), [&](const Vec3d& at) {
      const Vec3d q = (back * at - middle).cwiseAbs() - half;
      return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
    });
    ball = sampled(h, bounds(source), [&](const Vec3d& at) {
      const Vec3d p = back * at;
      return (p - Vec3d(std::clamp(p[0], -0.5 * kLong, 0.5 * kLong), 0, height)).norm() - radius;
    });
  }

  BrickField united(float sign) const {  // -1: the block less the ball
    BrickField out = phi0;
    for (std::size_t b = 0; b < out.brickCount(); ++b)
      for (std::size_t n = 0; n < kBrickNodes; ++n)
        out.brick(b)[n] = sign * std::min(sign * phi0.brick(b)[n], ball.brick(b)[n]);
    return out;
  }

  // The part of the ball's sweep beyond a plane at that distance from its middle.
  double volumeBeyond(double distance) const {
    const double cap = radius - distance, angle = std::acos(distance / radius);
    return std::numbers::pi * cap * cap * (3 * radius - cap) / 3 +
           kLong * (radius * radius * angle - distance * std::sqrt(radius * radius - distance * distance));
  }
};

// Before and after a cut shallower than a voxel, the surface lies between the same nodes.
TEST(PostOpMesh, AShallowCutHasItsVolume) {
  constexpr double kRadiusOfBall = 0.5;
  for (const double h : {0.05, 0.1})
    for (const double depth : {0.04, 0.1})
      for (const double tilt : {0.0, 0.35})
        for (const double up : {0.011, 0.047, 0.091}) {
          const BallAlongABlock c(h, kRadiusOfBall, kRadiusOfBall - depth, tilt, up);
          const double wanted = c.volumeBeyond(kRadiusOfBall - depth);
          const auto by_cut = postOperativeMesh(c.source, removedFieldFromCut(c.phi0, c.united(-1)));
          const auto by_sweep = postOperativeMesh(c.source, removedFieldFromSweep(c.phi0, c.ball));
          ASSERT_TRUE(by_cut && by_sweep);
          EXPECT_NEAR(by_cut->report.removed_volume_mm3 / wanted, 1, 0.03) << h << " " << depth << " " << tilt << up;
          EXPECT_NEAR(by_sweep->report.removed_volume_mm3 / wanted, 1, 0.03) << h << " " << depth << " " << tilt << up;
        }
}

TEST(PostOpMesh, AThinLayerThatIsAddedHasItsVolume) {
  constexpr double kRadiusOfBall = 0.5;
  for (const double thick : {0.04, 0.1})
    for (const double tilt : {0.0, 0.35})
      for (const double up : {0.011, 0.047, 0.091}) {
        const BallAlongABlock c(0.1, kRadiusOfBall, thick - kRadiusOfBall, tilt, up);
        const BrickField nothing(c.h, static_cast<float>(4 * c.h)), added = addedFieldFromFill(c.phi0, c.united(1));
        const auto out = postOperativeMesh(c.source, nothing, {}, {}, &added);
        ASSERT_TRUE(out) << out.error().message();
        EXPECT_NEAR(out->report.added_volume_mm3 / c.volumeBeyond(kRadiusOfBall - thick), 1, 0.03)
            << thick << " " << tilt << " " << up;
      }
}

TEST(PostOpMesh, WhatACutLeavesOfASmallObjectIsNoCrumb) {
  // At voxels of 1.5 mm, ten of them are 34 mm3. The remaining cap is smaller, and is the whole object.
  const Mesh source = ballMesh(Vec3d::Zero(), kRadius, 48);
  Box3 box;
  box.add(Vec3d::Zero());
  box.grow(kRadius);
  const double h = 1.5;
  const BrickField phi0 = sampled(h, box, [](const Vec3d& p) { return p.norm() - kRadius; });
  const BrickField sweep = sampled(h, box, [](const Vec3d& p) { return p[2] - 1.3; });
  const auto out = postOperativeMesh(source, removedFieldFromSweep(phi0, sweep));
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ(out->report.crumbs_dropped, 0u);
  EXPECT_GT(out->report.result_volume_mm3, 15);
  EXPECT_LT(out->report.result_volume_mm3, 34);
}

TEST(PostOpMesh, SmallPiecesTheCutDidNotTouchStay) {
  CutBall c;
  append(c.source, ballMesh({0, 0, -3.5}, 0.05, 8));
  const auto out = postOperativeMesh(c.source, c.rho);
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ(out->report.pieces, 2u);
}

TEST(PostOpMesh, ColoursStayOnTheSourceAndCutFacesHaveTheirOwn) {
  CutBall c;
  for (std::size_t v = 0; v < c.source.vertices.size(); ++v)
    c.source.vertex_colors.push_back({static_cast<std::uint8_t>(v % 251), static_cast<std::uint8_t>(v / 251), 7, 255});
  const auto out = postOperativeMesh(c.source, c.rho);
  ASSERT_TRUE(out) << out.error().message();
  std::size_t s = 0, walls = 0;
  for (std::size_t v = 0; v < out->mesh.vertices.size(); ++v) {
    if (!out->is_source[v]) {
      walls += out->mesh.vertex_colors[v] == PostOpOptions{}.cut_color;
      continue;
    }
    while (c.source.vertices[s] != out->mesh.vertices[v]) ++s;
    EXPECT_EQ(out->mesh.vertex_colors[v], c.source.vertex_colors[s]);
  }
  EXPECT_GT(walls, 50u);
}

TEST(PostOpMesh, NoCutGivesTheSourceBack) {
  const Mesh source = ballMesh(Vec3d::Zero(), kRadius, 24);
  const BrickField none(0.1, 0.4f);
  const auto out = postOperativeMesh(source, none);
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ(out->mesh.vertices, source.vertices);
  EXPECT_EQ(out->mesh.triangles, source.triangles);
}

TEST(PostOpMesh, TrianglesFarFromTheCutKeepTheirCornersAndOrder) {
  const CutBall c;
  const auto out = postOperativeMesh(c.source, c.rho);
  ASSERT_TRUE(out) << out.error().message();
  std::size_t at = 0, far = 0;
  for (std::size_t t = 0; t < c.source.triangles.size(); ++t) {
    if ((c.source.corner(t, 0) - c.center).norm() <= c.tool + 5 * c.h) continue;
    ++far;
    while (at < out->mesh.triangles.size() &&
           !(out->mesh.corner(at, 0) == c.source.corner(t, 0) && out->mesh.corner(at, 1) == c.source.corner(t, 1) &&
             out->mesh.corner(at, 2) == c.source.corner(t, 2)))
      ++at;
    ASSERT_LT(at, out->mesh.triangles.size()) << "triangle " << t << " is gone, turned or out of order";
  }
  EXPECT_GT(far, 1000u);
}

}  // namespace
}  // namespace kerf::post_op_mesh_test
