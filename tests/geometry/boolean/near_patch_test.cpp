#include "geometry/boolean/near_patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "geometry/boolean/boolean.h"
#include "geometry/mesh/crossing_pairs.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/geometry/sampled_field.h"

namespace kerf::near_patch_test {
namespace {

Mesh moved(Mesh mesh, const std::function<Vec3d(const Vec3d&)>& to) {
  for (Vec3d& p : mesh.vertices) p = roundedToFloat(to(p));
  return mesh;
}

// A ball stretched along the axes and moved.
Mesh ellipsoid(const Vec3d& center, const Vec3d& radii, int rings, bool inward = false) {
  return moved(ballMesh(Vec3d::Zero(), 1, rings, inward),
               [&](const Vec3d& p) { return Vec3d(center + p.cwiseProduct(radii)); });
}

Mesh torus(const Vec3d& center, double large, double small, int around) {
  Mesh m;
  const int across = around / 3;
  for (int a = 0; a < around; ++a)
    for (int b = 0; b < across; ++b) {
      const double u = 2 * std::numbers::pi * (a + 0.3) / around, v = 2 * std::numbers::pi * (b + 0.2) / across;
      const double r = large + small * std::cos(v);
      m.vertices.push_back(
          roundedToFloat(Vec3d(center + Vec3d(r * std::cos(u), small * std::sin(v), r * std::sin(u)))));
    }
  const auto at = [&](int a, int b) { return static_cast<std::uint32_t>((a % around) * across + b % across); };
  for (int a = 0; a < around; ++a)
    for (int b = 0; b < across; ++b) {
      m.triangles.push_back({at(a, b), at(a, b + 1), at(a + 1, b)});
      m.triangles.push_back({at(a + 1, b), at(a, b + 1), at(a + 1, b + 1)});
    }
  return m;
}

Mesh together(std::initializer_list<Mesh> parts) {
  Mesh all;
  for (const Mesh& part : parts) append(all, part);
  return Mesh{all.vertices, all.triangles, {}, {}};
}

struct Both {
  Difference near, whole;
};

void expectSame(const Difference& near, const Difference& whole) {
  EXPECT_EQ(near.mesh.vertices, whole.mesh.vertices);  // new vertices, too: both round the same exact points
  EXPECT_EQ(near.mesh.triangles, whole.mesh.triangles);
  EXPECT_EQ(near.from_vertex, whole.from_vertex);
  EXPECT_EQ(near.from_triangle, whole.from_triangle);
}

// The difference of the near part and that of the whole must agree in all results.
Both subtractBoth(const Mesh& source, const Mesh& other) {
  auto near = subtract(source, other), whole = subtract(source, other, Reach::kWhole);
  EXPECT_TRUE(near && whole);
  if (!near || !whole) return {};
  EXPECT_EQ(whole->triangles_taken, source.triangles.size());
  expectSame(*near, *whole);
  expectClosedManifold(near->mesh);
  return {*std::move(near), *std::move(whole)};
}

void expectNear(const Both& both, const Mesh& source) {
  EXPECT_GT(both.near.triangles_taken, 0u);
  EXPECT_LT(2 * both.near.triangles_taken, source.triangles.size());
}

const Mesh kBall = ballMesh(Vec3d::Zero(), 3, 96);

TEST(NearPatch, ACavityIsTheSameAsCutFromTheWhole) {
  const Both both = subtractBoth(kBall, ballMesh({0.31, 0.22, 2.9}, 0.7, 24));
  expectNear(both, kBall);
}

TEST(NearPatch, ACapCutOffIsTheSameAsCutFromTheWhole) {
  const Both both = subtractBoth(kBall, ellipsoid({0.1, 0.2, 4}, {5, 5, 1.7}, 40));
  expectNear(both, kBall);
}

TEST(NearPatch, ATunnelThroughBothWallsIsTheSameAsCutFromTheWhole) {
  for (const double width : {0.2, 0.5, 0.9}) {
    const Both both = subtractBoth(kBall, ellipsoid({0.1, 0.2, 0.3}, {width, width, 5}, 40));
    expectNear(both, kBall);
    EXPECT_EQ(edgeConnectedPieces(both.near.mesh).count, 1u);
  }
}

TEST(NearPatch, WhatIsSeveredIsTheSameAsCutFromTheWhole) {
  const Mesh bar = ellipsoid(Vec3d::Zero(), {12, 3, 2}, 96);
  const Both both = subtractBoth(bar, ellipsoid({2.1, 0.3, 0.2}, {0.3, 6, 6}, 40));
  expectNear(both, bar);
  EXPECT_EQ(edgeConnectedPieces(both.near.mesh).count, 2u);
}

TEST(NearPatch, NestedShellsAreTheSameAsCutFromTheWhole) {
  const Mesh hollow = together({kBall, ballMesh({0.2, 0, 0}, 2.2, 80, true), ballMesh({0.1, 0.1, 0}, 1, 40)});
  const std::array<Mesh, 5> others{ballMesh({0, 0.1, 2.9}, 0.3, 16),             // into the outer wall alone
                                   ballMesh({0, 0.1, 2.6}, 0.8, 24),             // through it, into the hollow
                                   ballMesh({0.1, 0.1, 0.9}, 0.4, 16),           // into the loose part in it
                                   ellipsoid({0.1, 0.2, 0}, {0.3, 0.3, 5}, 40),  // through all of them
                                   ballMesh({0.1, 0.1, 0.05}, 1.15, 40)};        // the whole loose part
  for (const Mesh& other : others) expectNear(subtractBoth(hollow, other), hollow);
}

TEST(NearPatch, ShellsThatNoSurfaceMeetsAreDecidedByTheWhole) {
  const Mesh hollow = together({kBall, ballMesh({0.2, 0, 0}, 1.2, 40, true)});
  const Mesh cut = ballMesh({0.3, 0.2, 2.9}, 0.5, 20);
  const Mesh within = ballMesh({0, 0, 2}, 0.2, 10), in_air = ballMesh({0, 0, 4}, 0.2, 10),
             in_hollow = ballMesh({0.2, 0, 0.1}, 0.3, 10);
  EXPECT_EQ(edgeConnectedPieces(subtractBoth(hollow, together({cut, within})).near.mesh).count, 3u);
  EXPECT_EQ(edgeConnectedPieces(subtractBoth(hollow, together({cut, in_air})).near.mesh).count, 2u);
  EXPECT_EQ(edgeConnectedPieces(subtractBoth(hollow, together({cut, in_hollow})).near.mesh).count, 2u);
  EXPECT_EQ(edgeConnectedPieces(subtractBoth(hollow, together({within, cut, in_air, in_hollow})).near.mesh).count, 3u);
  EXPECT_EQ(edgeConnectedPieces(subtractBoth(hollow, within).near.mesh).count, 3u);
  EXPECT_EQ(edgeConnectedPieces(subtractBoth(hollow, in_air).near.mesh).count, 2u);
}

TEST(NearPatch, AShellThatOnlyTouchesIsDecidedByTheWhole) {
  const auto highest = [](const Vec3d& a, const Vec3d& b) { return a[2] < b[2]; };
  const Vec3d pole = *std::max_element(kBall.vertices.begin(), kBall.vertices.end(), highest);
  Mesh tent;  // the pole is a point of its floor
  for (const Vec3d& p : {Vec3d(-0.25, -0.25, 0), Vec3d(0.25, -0.25, 0), Vec3d(0, 0.5, 0), Vec3d(0, 0, 0.5)})
    tent.vertices.push_back(pole + p);
  tent.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Mesh cut = ballMesh({2.9, 0.2, 0.1}, 0.7, 24);
  EXPECT_EQ(edgeConnectedPieces(subtractBoth(kBall, together({cut, tent})).near.mesh).count, 1u);
}

TEST(NearPatch, ALinkThroughItsOwnRimTakesTheWhole) {
  // Each loop around a hole of the plate also surrounds the ring, so no cap is clear of it.
  const Mesh plate = ellipsoid(Vec3d::Zero(), {20, 20, 0.4}, 120);
  const Mesh ring = torus({0.1, 0.2, 0.03}, 9, 0.6, 90);
  EXPECT_FALSE(internal::nearPatch(plate, ring));
  const Both both = subtractBoth(plate, ring);
  EXPECT_EQ(both.near.triangles_taken, plate.triangles.size());
}

TEST(NearPatch, ACutThroughMostOfTheMeshTakesTheWhole) {
  const Both both = subtractBoth(kBall, ballMesh({0.1, 0.2, 1}, 2.9, 60));
  EXPECT_EQ(both.near.triangles_taken, kBall.triangles.size());
}

TEST(NearPatch, AnOpenSourceAndOneThatCrossesItselfAreRefusedAsByTheWhole) {
  const Mesh cut = ballMesh({0.31, 0.22, 2.9}, 0.7, 24);
  Mesh open = kBall;
  open.triangles.pop_back();  // far from the cut
  EXPECT_FALSE(internal::nearPatch(open, cut));
  EXPECT_EQ(subtract(open, cut).has_value(), subtract(open, cut, Reach::kWhole).has_value());

  const Mesh crossing = together({kBall, ballMesh({1, 0.2, 2.8}, 0.5, 20)});
  const auto near = subtract(crossing, cut), whole = subtract(crossing, cut, Reach::kWhole);
  ASSERT_FALSE(whole);
  ASSERT_FALSE(near);
  EXPECT_EQ(near.error().message(), whole.error().message());

  Mesh kinked = cut;  // a cutter that crosses itself
  append(kinked, ballMesh({0.8, 0.22, 2.9}, 0.7, 24));
  EXPECT_FALSE(subtract(kBall, kinked, Reach::kWhole));
  EXPECT_FALSE(subtract(kBall, kinked));
}

TEST(NearPatch, RandomCutsAreTheSameAsFromTheWhole) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  const Mesh bar = ellipsoid({12, -7, 31}, {9, 3, 2}, 80);
  int near = 0;
  for (int n = 0; n < 12; ++n) {
    const Vec3d at = Vec3d(12, -7, 31) + Vec3d(8 * any(random), 3 * any(random), 2 * any(random));
    const Vec3d radii = Vec3d(0.6, 0.6, 0.6) + 0.5 * Vec3d(any(random), any(random), any(random));
    SCOPED_TRACE(n);
    near += subtractBoth(bar, ellipsoid(at, radii, 20)).near.triangles_taken < bar.triangles.size();
  }
  EXPECT_GT(near, 6);
}

TEST(NearPatch, AUnionIsTheSameAsWithTheWhole) {
  const Mesh lump = ballMesh({0.31, 0.22, 2.9}, 0.7, 24), apart = ballMesh({0, 0, 5}, 0.3, 10),
             within = ballMesh({0, 0, 0.5}, 0.3, 10);
  for (const Mesh& added : {together({lump, apart}), together({lump, within})}) {
    const auto near = unite(kBall, added), whole = unite(kBall, added, Reach::kWhole);
    ASSERT_TRUE(near && whole);
    expectSame(*near, *whole);
  }
  const auto near = unite(kBall, together({lump, apart}));
  ASSERT_TRUE(near);
  EXPECT_LT(2 * near->triangles_taken, kBall.triangles.size());
  EXPECT_EQ(edgeConnectedPieces(near->mesh).count, 2u);
}

TEST(NearPatch, ThePatchIsClosedHoldsAllThatIsNearAndItsCapsAreClear) {
  const Mesh other = ellipsoid({0.1, 0.2, 0.3}, {0.4, 0.4, 5}, 16);
  const auto patch = internal::nearPatch(kBall, other);
  ASSERT_TRUE(patch);
  expectClosedManifold(patch->mesh);

  std::vector<char> is_near(kBall.triangles.size(), 0);
  for (std::size_t t = 0; t < patch->source_triangles; ++t) {
    is_near[patch->triangle[t]] = 1;
    for (int k = 0; k < 3; ++k) EXPECT_EQ(patch->mesh.corner(t, k), kBall.corner(patch->triangle[t], k));
  }
  const auto cross = [&](const Mesh& mesh, std::size_t t) {
    Mesh pair{{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}, {{0, 1, 2}}, {}, {}};
    append(pair, other);
    for (const auto& [a, b] : selfIntersections(pair.vertices, pair.triangles))
      if (a == 0) return true;
    return false;
  };
  std::size_t crossed = 0;
  for (std::size_t t = 0; t < kBall.triangles.size(); t += is_near[t] ? 5 : 997) {
    const bool is_crossed = cross(kBall, t);
    crossed += is_crossed;
    EXPECT_TRUE(is_near[t] || !is_crossed);
  }
  EXPECT_GT(crossed, 3u);
  for (std::size_t t = patch->source_triangles; t < patch->triangle.size(); t += 53) {
    EXPECT_EQ(patch->triangle[t], kNoSource);
    EXPECT_FALSE(cross(patch->mesh, t));
  }
}

TEST(NearPatch, APatchWhoseCapsWereCutIsNotSewnToTheRest) {
  const auto patch = internal::nearPatch(kBall, ballMesh({0.31, 0.22, 2.9}, 0.7, 24));
  ASSERT_TRUE(patch);
  const auto other = ballMesh({0.31, 0.22, 2.9}, 0.69, 24), larger = ballMesh({0.31, 0.22, 2.9}, 1.5, 24);
  const auto fits = subtract(patch->mesh, other, Reach::kWhole), meets = subtract(patch->mesh, larger, Reach::kWhole);
  ASSERT_TRUE(fits && meets);
  EXPECT_TRUE(internal::sewnToRest(kBall, *patch, *fits));
  EXPECT_FALSE(internal::sewnToRest(kBall, *patch, *meets));
}

TEST(NearPatch, ATriangleIsApartFromABoxAsItsPointsSay) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto point = [&](double reach) { return Vec3d(reach * Vec3d(any(random), any(random), any(random))); };
  std::size_t apart = 0, wrong = 0;
  for (int n = 0; n < 2000; ++n) {
    Box3 box;
    box.add(point(1));
    box.add(point(1));
    const Vec3d a = point(2), b = point(2), c = point(2);
    double nearest = std::numeric_limits<double>::infinity();  // of a fine grid of points of the triangle
    for (int i = 0; i <= 60; ++i)
      for (int j = 0; i + j <= 60; ++j) {
        const Vec3d p = a + (b - a) * i / 60.0 + (c - a) * j / 60.0;
        nearest = std::min(nearest, (p - p.cwiseMax(box.min).cwiseMin(box.max)).norm());
      }
    const bool is_apart = internal::isApart(a, b, c, box);
    apart += is_apart;
    EXPECT_FALSE(is_apart && nearest == 0);
    wrong += !is_apart && nearest > 0.1;  // farther than the spacing of the grid points
  }
  EXPECT_GT(apart, 200u);
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace kerf::near_patch_test
