#include "preprocess/demo/demo_molar.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "geometry/mesh/self_intersection.h"
#include "preprocess/volume/tetrahedral_mesher.h"

namespace kerf::demo_molar_test {
namespace {

/// Every edge has exactly two triangles of opposite direction, and the triangles around every vertex form one fan.
void expectClosedManifold(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  std::vector<std::vector<std::uint32_t>> next(mesh.vertices.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> across;  // (vertex, corner after) -> corner before
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      ++uses[{t[k], t[(k + 1) % 3]}];
      across[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
      next[t[k]].push_back(t[(k + 1) % 3]);
    }
  for (const auto& [edge, count] : uses) {
    ASSERT_EQ(count, 1) << edge.first << "-" << edge.second;
    ASSERT_TRUE(uses.count({edge.second, edge.first})) << edge.first << "-" << edge.second;
  }
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    ASSERT_FALSE(next[v].empty()) << "vertex " << v << " is not used";
    std::size_t steps = 0;
    for (std::uint32_t w = next[v][0]; steps == 0 || w != next[v][0]; w = across.at({v, w})) ++steps;
    ASSERT_EQ(steps, next[v].size()) << "vertex " << v << " joins two fans";
  }
}

double meanEdge(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) sum += (mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3)).norm();
  return sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

class DemoMolar : public ::testing::Test {
 protected:
  static const Mesh& mesh() {
    static const Mesh mesh = demoMolar();
    return mesh;
  }
};

TEST_F(DemoMolar, IsOneClosedManifold) {
  expectClosedManifold(mesh());
  EXPECT_EQ(edgeConnectedPieces(mesh()).count, 1u);
  // Euler: a solid without handles.
  EXPECT_EQ(static_cast<long>(mesh().vertices.size()) - static_cast<long>(mesh().triangles.size()) / 2, 2);
}

TEST_F(DemoMolar, DoesNotCrossItself) {
  for (const double edge : {0.12, 0.18, 0.3, 0.6, 1.0}) {
    const Mesh molar = demoMolar(edge);
    EXPECT_TRUE(selfIntersections(molar.vertices, molar.triangles).empty()) << edge;
    EXPECT_TRUE(degenerateTriangles(molar.vertices, molar.triangles).empty()) << edge;
    // Also when written as float32.
    std::vector<Vec3d> rounded;
    for (const Vec3d& p : molar.vertices) rounded.push_back(p.cast<float>().cast<double>());
    EXPECT_TRUE(selfIntersections(rounded, molar.triangles).empty()) << edge;
  }
}

TEST_F(DemoMolar, HasTheDimensionsOfALowerFirstMolar) {
  const Box3 box = bounds(mesh());
  EXPECT_NEAR(box.size().x(), 11.0, 0.2);   // mesio-distal
  EXPECT_NEAR(box.size().y(), 10.5, 0.25);  // bucco-lingual
  EXPECT_NEAR(box.max.z(), 7.5, 0.25);      // crown
  EXPECT_NEAR(box.min.z(), -14.0, 0.2);     // root
  Box3 cervix;
  for (const Vec3d& p : mesh().vertices)
    if (std::abs(p.z()) < 0.15) cervix.add(p);
  EXPECT_NEAR(cervix.size().x(), 9.0, 0.3);
  // The tooth fills between 35 and 50 % of its box.
  EXPECT_GT(signedVolume(mesh()), 0.35 * 11 * 10.5 * 21.5);
  EXPECT_LT(signedVolume(mesh()), 0.50 * 11 * 10.5 * 21.5);
  EXPECT_GT(mesh().triangles.size(), 30000u);
  EXPECT_LT(mesh().triangles.size(), 60000u);
  EXPECT_NEAR(meanEdge(mesh()), 0.18, 0.018);
  EXPECT_NEAR(meanEdge(demoMolar(0.4)), 0.4, 0.04);
}

TEST_F(DemoMolar, HasFiveCuspsAndAFossaBetween) {
  // Tips: vertices higher than everything within 0.9 mm, in the upper part of the crown.
  int tips = 0;
  for (const Vec3d& p : mesh().vertices) {
    if (p.z() < 6) continue;
    tips += std::none_of(mesh().vertices.begin(), mesh().vertices.end(),
                         [&](const Vec3d& q) { return q.z() > p.z() && (q - p).norm() < 0.9; });
  }
  EXPECT_EQ(tips, 5);
  EXPECT_GT(demoMolarDistance({0.1, -0.1, 5.5}), 0);  // open above the central pit,
  EXPECT_LT(demoMolarDistance({0.1, -0.1, 3.5}), 0);  // solid under it
}

TEST_F(DemoMolar, RootsPartThreeToFourMillimetresBelowTheCrown) {
  EXPECT_LT(demoMolarDistance({0, 0, -2.5}), 0);
  for (double y = -5; y <= 5; y += 0.25) EXPECT_GT(demoMolarDistance({-0.1, y, -4.2}), 0) << y;
  EXPECT_LT(demoMolarDistance({3.0, 0, -8}), 0);
  EXPECT_LT(demoMolarDistance({-3.5, 0, -8}), 0);
}

TEST_F(DemoMolar, DistanceIsFirstOrderNearTheSurface) {
  std::mt19937 random(7);
  std::vector<double> errors;
  for (int i = 0; i < 4000; ++i) {
    const std::size_t t = random() % mesh().triangles.size();
    const Vec3d n = doubleAreaVector(mesh(), t).normalized();
    const Vec3d p = (mesh().corner(t, 0) + mesh().corner(t, 1) + mesh().corner(t, 2)) / 3;
    const double off = (random() % 2 ? 1 : -1) * 0.1;
    const double d = demoMolarDistance(p + off * n);
    ASSERT_GT(d * off, 0) << "wrong side at " << p.transpose();
    errors.push_back(std::abs(d - off));
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.003);
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.03);
}

TEST_F(DemoMolar, VerticesLieOnTheSurface) {
  for (const Vec3d& p : mesh().vertices) ASSERT_LT(std::abs(demoMolarDistance(p)), 0.02) << p.transpose();
}

TEST_F(DemoMolar, CrownIsLighterThanTheRoots) {
  ASSERT_EQ(mesh().vertex_colors.size(), mesh().vertices.size());
  for (std::size_t v = 0; v < mesh().vertices.size(); ++v) {
    const double z = mesh().vertices[v].z();
    if (z < -1) {
      EXPECT_LT(mesh().vertex_colors[v][2], 170);
    }
    if (z > 1 && z < 3.5) {
      EXPECT_GT(mesh().vertex_colors[v][2], 195);
    }
  }
}

TEST_F(DemoMolar, IsTheSameEveryTime) {
  const Mesh again = demoMolar();
  EXPECT_EQ(again.triangles, mesh().triangles);
  EXPECT_EQ(again.vertex_colors, mesh().vertex_colors);
  EXPECT_TRUE(again.vertices == mesh().vertices);
}

TEST(TetrahedralMesher, ClosesWhiteNoiseWithoutCrossings) {
  // Works for any function: here a random value per place, positive at the border.
  const auto noise = [](const Vec3d& p) {
    if (p.cwiseAbs().maxCoeff() > 0.9) return 1.0;
    const double h = std::sin(p.dot(Vec3d(127.1, 311.7, 74.7))) * 43758.5453;
    return h - std::floor(h) - 0.5;
  };
  const Mesh mesh = internal::meshImplicit(noise, {Vec3d::Constant(-1.2), Vec3d::Constant(1.2)}, 0.15, 0);
  EXPECT_GT(mesh.triangles.size(), 10000u);
  expectClosedManifold(mesh);
  EXPECT_TRUE(selfIntersections(mesh.vertices, mesh.triangles).empty());
}

TEST(TetrahedralMesher, BallHasItsVolume) {
  const auto ball = [](const Vec3d& p) { return p.norm() - 2; };
  const Mesh mesh = internal::meshImplicit(ball, {Vec3d::Constant(-2.5), Vec3d::Constant(2.5)}, 0.2);
  expectClosedManifold(mesh);
  EXPECT_NEAR(signedVolume(mesh) / (4.0 / 3 * 3.14159265358979 * 8), 1, 0.005);
}

TEST(TetrahedralMesher, SkippingEmptyBlocksChangesNothing) {
  const auto ring = [](const Vec3d& p) { return std::hypot(std::hypot(p.x(), p.y()) - 3, p.z()) - 0.8; };
  const Box3 box{Vec3d(-5, -5, -2), Vec3d(5, 5, 2)};
  const Mesh all = internal::meshImplicit(ring, box, 0.2), skipped = internal::meshImplicit(ring, box, 0.2, 3, 1.0);
  int calls = 0;
  const auto counted = [&](const Vec3d& p) {
    ++calls;
    return ring(p);
  };
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  internal::meshImplicit(counted, box, 0.2, 0, 1.0);
  const int with_skipping = std::exchange(calls, 0);
  internal::meshImplicit(counted, box, 0.2, 0);
  EXPECT_EQ(skipped.triangles, all.triangles);
  EXPECT_TRUE(skipped.vertices == all.vertices);
  EXPECT_LT(with_skipping, 0.7 * calls);
}

TEST(TetrahedralMesher, EveningOutNeverMakesTheSidesOfANarrowSlotCross) {
  // Two balls a tenth of an edge apart, and a saddle where the gap opens.
  const auto balls = [](const Vec3d& p) {
    return std::min((p - Vec3d(1.51, 0, 0)).norm(), (p + Vec3d(1.51, 0, 0)).norm()) - 1.5;
  };
  Mesh mesh = internal::meshImplicit(balls, {Vec3d(-3.5, -2, -2), Vec3d(3.5, 2, 2)}, 0.45);
  internal::evenOut(mesh, balls, 6);
  expectClosedManifold(mesh);
  EXPECT_TRUE(selfIntersections(mesh.vertices, mesh.triangles).empty());
}

TEST(TetrahedralMesher, WhatCrossesGoesBackToWhereItWas) {
  const auto ball = [](const Vec3d& p) { return p.norm() - 2; };
  Mesh mesh = internal::meshImplicit(ball, {Vec3d::Constant(-2.5), Vec3d::Constant(2.5)}, 0.4);
  const std::vector<Vec3d> before = mesh.vertices;
  mesh.vertices[7] = -1.5 * mesh.vertices[7];  // through the opposite side
  mesh.vertices[100] *= 1.01;                  // crosses nothing
  ASSERT_FALSE(selfIntersections(mesh.vertices, mesh.triangles).empty());
  internal::undoCrossings(mesh, before);
  EXPECT_TRUE(selfIntersections(mesh.vertices, mesh.triangles).empty());
  EXPECT_EQ(mesh.vertices[7], before[7]);
  EXPECT_NE(mesh.vertices[100], before[100]);
}

}  // namespace
}  // namespace kerf::demo_molar_test
