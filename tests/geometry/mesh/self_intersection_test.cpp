#include "geometry/mesh/self_intersection.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

namespace kerf::self_intersection_test {
namespace {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// The same test in exact integers: all pairs, without boxes, filters or CGAL.
namespace reference {

using P = std::array<std::int64_t, 3>;

std::int64_t side(const P& a, const P& b, const P& c, const P& d) {
  const auto x = [&](const P& p, std::size_t k) { return p[k] - a[k]; };
  return x(b, 0) * (x(c, 1) * x(d, 2) - x(c, 2) * x(d, 1)) - x(b, 1) * (x(c, 0) * x(d, 2) - x(c, 2) * x(d, 0)) +
         x(b, 2) * (x(c, 0) * x(d, 1) - x(c, 1) * x(d, 0));
}

P normal(const P& a, const P& b, const P& c) {
  P n;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    n[k] = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
  }
  return n;
}

bool segmentMeetsTriangle(const P& p, const P& q, const P& a, const P& b, const P& c) {
  const std::int64_t sp = side(a, b, c, p), sq = side(a, b, c, q);
  if ((sp > 0 && sq > 0) || (sp < 0 && sq < 0)) return false;
  if (sp != 0 || sq != 0) {
    const std::int64_t u = side(p, q, a, b), v = side(p, q, b, c), w = side(p, q, c, a);
    return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
  }
  const P n = normal(a, b, c);
  std::size_t drop = 0;
  while (n[drop] == 0) ++drop;
  const std::size_t x = (drop + 1) % 3, y = (drop + 2) % 3;
  const auto turn = [&](const P& r, const P& s, const P& t) {
    const std::int64_t d = (s[x] - r[x]) * (t[y] - r[y]) - (s[y] - r[y]) * (t[x] - r[x]);
    return d > 0 ? 1 : d < 0 ? -1 : 0;
  };
  const auto within = [&](const P& r, const P& s, const P& t) {  // t on line rs: between them?
    return std::min(r[x], s[x]) <= t[x] && t[x] <= std::max(r[x], s[x]) && std::min(r[y], s[y]) <= t[y] &&
           t[y] <= std::max(r[y], s[y]);
  };
  const auto cross = [&](const P& r, const P& s) {
    const int d1 = turn(p, q, r), d2 = turn(p, q, s), d3 = turn(r, s, p), d4 = turn(r, s, q);
    if (d1 * d2 < 0 && d3 * d4 < 0) return true;
    return (d1 == 0 && within(p, q, r)) || (d2 == 0 && within(p, q, s)) || (d3 == 0 && within(r, s, p)) ||
           (d4 == 0 && within(r, s, q));
  };
  const int u = turn(a, b, p), v = turn(b, c, p), w = turn(c, a, p);
  const bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
  return inside || cross(a, b) || cross(b, c) || cross(c, a);
}

Pairs selfIntersections(const std::vector<P>& v, const std::vector<Triangle>& triangles) {
  Pairs pairs;
  const auto flat = [&](const Triangle& t) { return normal(v[t[0]], v[t[1]], v[t[2]]) == P{0, 0, 0}; };
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    for (std::uint32_t j = i + 1; j < triangles.size(); ++j) {
      const Triangle &s = triangles[i], &t = triangles[j];
      if (flat(s) || flat(t)) continue;
      std::vector<std::uint32_t> shared, s_only, t_only;
      for (const auto x : s) (std::find(t.begin(), t.end(), x) != t.end() ? shared : s_only).push_back(x);
      for (const auto x : t)
        if (std::find(s.begin(), s.end(), x) == s.end()) t_only.push_back(x);
      bool meet = true;
      if (shared.size() == 2) {
        const P n = normal(v[shared[0]], v[shared[1]], v[s_only[0]]),
                m = normal(v[shared[0]], v[shared[1]], v[t_only[0]]);
        meet = side(v[s[0]], v[s[1]], v[s[2]], v[t_only[0]]) == 0 && n[0] * m[0] + n[1] * m[1] + n[2] * m[2] > 0;
      } else if (shared.size() == 1) {
        meet = segmentMeetsTriangle(v[s_only[0]], v[s_only[1]], v[t[0]], v[t[1]], v[t[2]]) ||
               segmentMeetsTriangle(v[t_only[0]], v[t_only[1]], v[s[0]], v[s[1]], v[s[2]]);
      } else if (shared.empty()) {
        meet = false;
        for (std::size_t k = 0; k < 3; ++k)
          meet |= segmentMeetsTriangle(v[s[k]], v[s[(k + 1) % 3]], v[t[0]], v[t[1]], v[t[2]]) ||
                  segmentMeetsTriangle(v[t[k]], v[t[(k + 1) % 3]], v[s[0]], v[s[1]], v[s[2]]);
      }
      if (meet) pairs.emplace_back(i, j);
    }
  return pairs;
}

}  // namespace reference

TEST(SelfIntersection, AgreesWithIntegersOnRandomSoups) {
  std::mt19937 random(20261);
  std::size_t found = 0, clean = 0;
  for (int round = 0; round < 3000; ++round) {
    // Small grids give many touching, coplanar, collinear and folded cases; large grids give the general case.
    const int extent = std::array{2, 3, 6, 40}[static_cast<std::size_t>(round % 4)];
    std::uniform_int_distribution<int> coordinate(0, extent);
    std::vector<reference::P> points(10);
    for (auto& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    std::uniform_int_distribution<std::uint32_t> index(0, static_cast<std::uint32_t>(points.size() - 1));
    std::vector<Triangle> triangles(10);
    for (Triangle& t : triangles) t = {index(random), index(random), index(random)};
    // A shift and scale that are exact in double.
    std::vector<Vec3d> vertices;
    for (const auto& p : points)
      vertices.emplace_back(200 + 0.125 * static_cast<double>(p[0]), 0.125 * static_cast<double>(p[1]),
                            -7 + 0.125 * static_cast<double>(p[2]));
    const Pairs expected = reference::selfIntersections(points, triangles);
    ASSERT_EQ(selfIntersections(vertices, triangles), expected) << "round " << round;
    found += expected.size();
    clean += expected.empty();
  }
  EXPECT_GT(found, 10000u);
  EXPECT_GT(clean, 20u);
}

Pairs of(const std::vector<Vec3d>& vertices, const std::vector<Triangle>& triangles) {
  return selfIntersections(vertices, triangles);
}
const Pairs kMeet{{0, 1}}, kNone;
const std::vector<Vec3d> kBase{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};

std::vector<Vec3d> with(std::vector<Vec3d> more) {
  std::vector<Vec3d> v = kBase;
  v.insert(v.end(), more.begin(), more.end());
  return v;
}

TEST(SelfIntersection, PairsWithoutASharedVertex) {
  const std::vector<Triangle> two{{0, 1, 2}, {3, 4, 5}};
  EXPECT_EQ(of(with({{1, 1, -1}, {1, 1, 1}, {9, 9, 1}}), two), kMeet) << "crossing";
  EXPECT_EQ(of(with({{1, 1, 0}, {1, 1, 1}, {2, 1, 1}}), two), kMeet) << "a corner touches the face";
  EXPECT_EQ(of(with({{4, 0, 0}, {5, 0, 1}, {5, 1, 1}}), two), kMeet) << "corners touch, not welded";
  EXPECT_EQ(of(with({{1, 1, 0}, {9, 1, 0}, {1, 9, 0}}), two), kMeet) << "coplanar, overlapping";
  EXPECT_EQ(of(with({{5, 5, 0}, {9, 5, 0}, {5, 9, 0}}), two), kNone) << "coplanar, apart";
  EXPECT_EQ(of(with({{1, 1, 5e-324}, {1, 1, 1}, {2, 1, 1}}), two), kNone) << "apart by the smallest number there is";
}

TEST(SelfIntersection, PairsSharingAVertex) {
  const std::vector<Triangle> two{{0, 1, 2}, {0, 3, 4}};
  EXPECT_EQ(of(with({{2, 2, 1}, {2, 2, -1}}), two), kMeet) << "passes through";
  EXPECT_EQ(of(with({{-1, 0, 1}, {-1, 0, -1}}), two), kNone);
  EXPECT_EQ(of(with({{1, 1, 0}, {1, 1, 1}}), two), kMeet) << "an edge lies in the face";
  EXPECT_EQ(of(with({{1, 2, 0}, {2, 1, 0}}), two), kMeet) << "coplanar, inside";
  EXPECT_EQ(of(with({{-1, 0, 0}, {0, -1, 0}}), two), kNone) << "coplanar, opposite";
}

TEST(SelfIntersection, PairsSharingAnEdge) {
  const std::vector<Triangle> two{{0, 1, 2}, {1, 0, 3}};
  EXPECT_EQ(of(with({{1, -1, 0}}), two), kNone) << "flat";
  EXPECT_EQ(of(with({{1, 1, 1e-300}}), two), kNone) << "almost folded over";
  EXPECT_EQ(of(with({{1, 1, 0}}), two), kMeet) << "folded over";
  EXPECT_EQ(of(kBase, {{0, 1, 2}, {2, 1, 0}}), kMeet) << "the same face twice";
}

TEST(SelfIntersection, DegenerateTrianglesAreListedAndTakeNoPart) {
  const std::vector<Vec3d> v = with({{2, 2, 0}, {1, 1, 0}, {3, 1, 0}});
  const std::vector<Triangle> triangles{{0, 1, 2}, {1, 3, 2}, {0, 0, 4}, {5, 3, 5}, {3, 4, 5}};
  EXPECT_EQ(degenerateTriangles(v, triangles), (std::vector<std::uint32_t>{1, 2, 3}));
  EXPECT_EQ(selfIntersections(v, triangles), (Pairs{{0, 4}}));
  EXPECT_TRUE(selfIntersections({}, {}).empty());
}

TEST(SelfIntersection, AnswerDoesNotDependOnThreads) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(0, 60), small(-1, 1);
  std::vector<Vec3d> v;
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const Vec3d c(coordinate(random), coordinate(random), coordinate(random));
    for (int k = 0; k < 3; ++k) v.push_back(c + Vec3d(small(random), small(random), small(random)));
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const Pairs all = selfIntersections(v, triangles), some = selfIntersections(v, triangles, 7);
  EXPECT_GT(all.size(), 100u);
  ASSERT_EQ(some.size(), 7u);
  for (const auto& pair : some) EXPECT_TRUE(std::binary_search(all.begin(), all.end(), pair));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(selfIntersections(v, triangles), all);
  EXPECT_EQ(selfIntersections(v, triangles, 7), some);
}

// This avoids 200 million pairs.
TEST(SelfIntersection, ALimitedSearchOfOneTriangleManyTimesIsShort) {
  const std::vector<Vec3d> v{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}};
  const std::vector<Triangle> copies(20'000, Triangle{0, 1, 2});
  const Pairs some = selfIntersections(v, copies, 1000);
  EXPECT_EQ(some.size(), 1000u);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(selfIntersections(v, copies, 1000), some);
}

}  // namespace
}  // namespace kerf::self_intersection_test
