#include "geometry/mesh/float32_cleanup.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "geometry/mesh/crossing_pairs.h"

namespace kerf::float32_cleanup_test {
namespace {

/// A closed strip like a cylinder: a grid of quads around, two poles. A test may set positions.
Mesh ball(int rings, int sectors, double r, const Vec3d& at) {
  Mesh m;
  m.vertices.push_back(at + Vec3d(0, 0, r));
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      const double a = M_PI * i / rings, b = 2 * M_PI * j / sectors;
      m.vertices.push_back(at + r * Vec3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  m.vertices.push_back(at - Vec3d(0, 0, r));
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (i - 1) * sectors + j % sectors); };
  const auto south = static_cast<std::uint32_t>(m.vertices.size() - 1);
  for (int j = 0; j < sectors; ++j) {
    m.triangles.push_back({0, id(1, j), id(1, j + 1)});
    m.triangles.push_back({south, id(rings - 1, j + 1), id(rings - 1, j)});
    for (int i = 1; i + 1 < rings; ++i) {
      m.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      m.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return m;
}

/// Splits triangle t at a point inside: three new triangles (the last two at the end).
std::uint32_t splitAt(Mesh& m, std::size_t t, const Vec3d& p) {
  const auto v = static_cast<std::uint32_t>(m.vertices.size());
  m.vertices.push_back(p);
  const Triangle f = m.triangles[t];
  m.triangles[t] = {f[0], f[1], v};
  m.triangles.push_back({f[1], f[2], v});
  m.triangles.push_back({f[2], f[0], v});
  return v;
}

bool isClosedManifold(const Mesh& m) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Triangle& f : m.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{f[k], f[(k + 1) % 3]}];
  for (const auto& [e, count] : edges) {
    const auto back = edges.find({e.second, e.first});
    if (count != 1 || back == edges.end() || back->second != 1) return false;
  }
  return true;
}

TEST(Float32Cleanup, SliversAndShortEdgesVanishAndFixedVerticesStay) {
  Mesh m = ball(20, 40, 10, {60.1, -33.3, 7.7});
  for (Vec3d& p : m.vertices) p = roundedToFloat(p);
  const std::vector<Vec3d> source = m.vertices;
  std::vector<char> fixed(m.vertices.size(), 1);
  // New vertices of a boolean: a few nanometres from a corner and from an edge of existing triangles.
  for (std::size_t t = 100; t < 400; t += 7) {
    const Vec3d a = m.corner(t, 0), b = m.corner(t, 1), c = m.corner(t, 2);
    const double w = (t % 2) ? 1e-7 : 1e-5;
    splitAt(m, t, t % 3 ? Vec3d((1 - 2 * w) * a + w * b + w * c) : Vec3d(.5 * (1 - w) * (a + b) + w * c));
  }
  fixed.resize(m.vertices.size(), 0);
  const std::size_t triangles_before = m.triangles.size();
  std::vector<std::uint32_t> tag(m.triangles.size());
  for (std::uint32_t t = 0; t < tag.size(); ++t) tag[t] = t;
  const double volume = signedVolume(m);

  const auto report = cleanUpForFloat32(m, fixed, &tag, 1e-3);
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_EQ(report->crossings_left, 0u);
  EXPECT_EQ(report->fixed_moved, 0u);
  EXPECT_GT(report->collapsed, 20u);
  EXPECT_LT(report->largest_move_mm, 4e-3);
  EXPECT_TRUE(isClosedManifold(m));
  EXPECT_TRUE(crossingPairs(m).empty());
  EXPECT_LT(m.triangles.size(), triangles_before);
  EXPECT_EQ(tag.size(), m.triangles.size());
  EXPECT_EQ(fixed.size(), m.vertices.size());
  ASSERT_GE(m.vertices.size(), source.size());
  for (std::size_t v = 0; v < source.size(); ++v) EXPECT_EQ(m.vertices[v], source[v]);
  for (const Vec3d& p : m.vertices) EXPECT_EQ(p, Vec3d(roundedToFloat(p)));
  EXPECT_NEAR(signedVolume(m), volume, 1e-3);
}

TEST(Float32Cleanup, RoundingRounds) {
  // Two neighbours in memory: g++ 12 vectorises them, and then omits the rounding.
  std::vector<Vec3d> points;
  for (int i = 1; i < 50; ++i) points.push_back({std::sin(i), std::cos(i), std::sqrt(i)});
  std::size_t changed = 0;
  for (Vec3d& p : points) {
    const Vec3d r = roundedToFloat(p);
    changed += r != p;
    p = r;
  }
  EXPECT_EQ(changed, 49u);
  for (const Vec3d& p : points) {
    const volatile float x = static_cast<float>(p.x()), y = static_cast<float>(p.y()), z = static_cast<float>(p.z());
    EXPECT_EQ(p, Vec3d(x, y, z));
  }
}

TEST(Float32Cleanup, CleanMeshIsLeftAlone) {
  Mesh m = ball(10, 20, 5, Vec3d::Zero());
  for (Vec3d& p : m.vertices) p = roundedToFloat(p);
  const Mesh before = m;
  std::vector<char> fixed(m.vertices.size(), 0);
  const auto report = cleanUpForFloat32(m, fixed, nullptr, 1e-3);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->collapsed + report->flipped + report->relaxed, 0u);
  EXPECT_EQ(report->largest_move_mm, 0.0);
  EXPECT_EQ(m.vertices, before.vertices);
  EXPECT_EQ(m.triangles, before.triangles);
}

TEST(Float32Cleanup, WhatCannotBeMendedIsReported) {
  Mesh m = ball(8, 16, 5, Vec3d::Zero());
  append(m, ball(8, 16, 5, {3, 0, 0}));  // two balls through each other: the clean-up must not hide that
  for (Vec3d& p : m.vertices) p = roundedToFloat(p);
  std::vector<char> fixed(m.vertices.size(), 1);
  const std::vector<Vec3d> before = m.vertices;
  const auto report = cleanUpForFloat32(m, fixed, nullptr, 1e-3);
  ASSERT_TRUE(report);
  EXPECT_GT(report->crossings_left, 10u);
  EXPECT_EQ(m.vertices, before);
}

TEST(Float32Cleanup, FixedFlagsAndTagsMustFit) {
  Mesh m = ball(4, 6, 1, Vec3d::Zero());
  std::vector<char> fixed(3);
  EXPECT_FALSE(cleanUpForFloat32(m, fixed, nullptr, 1e-3));
}

}  // namespace
}  // namespace kerf::float32_cleanup_test
