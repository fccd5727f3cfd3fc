// Shapes to close, and the checks of every solid.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "geometry/mesh/float32_cleanup.h"
#include "geometry/mesh/self_intersection.h"
#include "preprocess/close/close.h"

namespace kerf {

/// An axis-aligned box, 12 triangles, outward.
inline Mesh box(const Vec3d& lo, const Vec3d& hi) {
  Mesh m;
  for (int i = 0; i < 8; ++i)
    m.vertices.push_back({i & 1 ? hi.x() : lo.x(), i & 2 ? hi.y() : lo.y(), i & 4 ? hi.z() : lo.z()});
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}
inline Mesh box(double lo, double hi) { return box(Vec3d::Constant(lo), Vec3d::Constant(hi)); }

inline Mesh ball(int rings, int sectors, double r) {
  Mesh m;
  m.vertices.push_back({0, 0, r});
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      const double a = M_PI * i / rings, b = 2 * M_PI * j / sectors;
      m.vertices.push_back(r * Vec3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  m.vertices.push_back({0, 0, -r});
  for (Vec3d& p : m.vertices) p = roundedToFloat(p);
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

inline Mesh flipped(Mesh m) {
  for (Triangle& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}
inline Mesh both(Mesh a, const Mesh& b) {
  append(a, b);
  return a;
}

/// Closed, 2-manifold at edges and vertices, without self-intersection, float32, no two vertices at one place.
inline void expectSolid(const Solid& s) {
  const Mesh& m = s.mesh;
  ASSERT_EQ(s.source_triangle.size(), m.triangles.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Triangle& f : m.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{f[k], f[(k + 1) % 3]}];
  for (const auto& [e, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(edges.count({e.second, e.first}));
  }

  std::vector<std::map<std::uint32_t, std::uint32_t>> next(m.vertices.size());
  for (const Triangle& f : m.triangles)
    for (std::size_t k = 0; k < 3; ++k) next[f[k]][f[(k + 1) % 3]] = f[(k + 2) % 3];
  for (const auto& fan : next) {
    ASSERT_FALSE(fan.empty()) << "a vertex no triangle uses";
    std::size_t steps = 0;
    std::uint32_t at = fan.begin()->first;
    do {
      at = fan.at(at);
      ++steps;
    } while (at != fan.begin()->first && steps <= fan.size());
    ASSERT_EQ(steps, fan.size()) << "a bow-tie vertex";
  }

  std::set<std::array<double, 3>> places;
  for (const Vec3d& p : m.vertices) {
    ASSERT_EQ(p, Vec3d(roundedToFloat(p)));
    ASSERT_TRUE(places.insert({p.x(), p.y(), p.z()}).second) << "two vertices at one place";
  }
  EXPECT_TRUE(selfIntersections(m.vertices, m.triangles).empty());
  EXPECT_TRUE(degenerateTriangles(m.vertices, m.triangles).empty());
  EXPECT_GT(signedVolume(m), 0);
}

/// The first vertices of the solid equal those of `m`, bit for bit.
inline void expectSourceFirst(const Solid& s, const Mesh& m) {
  ASSERT_GE(s.mesh.vertices.size(), m.vertices.size());
  for (std::size_t v = 0; v < m.vertices.size(); ++v) ASSERT_EQ(s.mesh.vertices[v], m.vertices[v]);
}

inline Solid closed(const Mesh& m, const CloseOptions& options = {}) {
  auto s = closeMesh(m, options);
  EXPECT_TRUE(s) << s.error().message();
  if (!s) return {};
  expectSolid(*s);
  EXPECT_TRUE(s->report.exact) << fmt::format("{}", fmt::join(s->report.changes, "; "));
  return *s;
}

}  // namespace kerf
