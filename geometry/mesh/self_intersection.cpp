#include "geometry/mesh/self_intersection.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace kerf {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Pair = std::pair<std::uint32_t, std::uint32_t>;

Point exactPoint(const Vec3d& p) { return {p.x(), p.y(), p.z()}; }

// A determinant below this could have lost digits to underflow; then the bounds below mean nothing.
constexpr double kUnderflow = 1e-200;

// Sign of det(b-a, c-a, d-a) when it is certain, 0 otherwise. Bound: Shewchuk, "Adaptive precision floating-point
// arithmetic and fast robust geometric predicates", 1997 (o3derrboundA).
int certainSide(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Vec3d u = b - a, v = c - a, w = d - a;
  const double m0 = u.y() * v.z(), m1 = u.z() * v.y(), m2 = u.z() * v.x(), m3 = u.x() * v.z(), m4 = u.x() * v.y(),
               m5 = u.y() * v.x();
  const double det = w.x() * (m0 - m1) + w.y() * (m2 - m3) + w.z() * (m4 - m5);
  const double permanent = std::abs(w.x()) * (std::abs(m0) + std::abs(m1)) +
                           std::abs(w.y()) * (std::abs(m2) + std::abs(m3)) +
                           std::abs(w.z()) * (std::abs(m4) + std::abs(m5));
  if (!(permanent > kUnderflow)) return 0;
  const double bound = 8e-16 * permanent;
  return det > bound ? 1 : det < -bound ? -1 : 0;
}

using Corners = std::array<Vec3d, 3>;

// True if the plane through `origin` across `axis` certainly separates a from b. `axis` may be any vector, used
// exactly; the bound covers only the products (three products, two sums, one difference each: 6 roundings).
bool separates(const Vec3d& axis, const Vec3d& origin, const Vec3d* a, int na, const Vec3d* b, int nb, bool strict) {
  const Vec3d weight = axis.cwiseAbs();
  double max_a = -std::numeric_limits<double>::infinity(), min_b = std::numeric_limits<double>::infinity(), scale = 0;
  for (int i = 0; i < na; ++i) {
    const Vec3d r = a[i] - origin;
    max_a = std::max(max_a, axis.dot(r));
    scale = std::max(scale, weight.dot(r.cwiseAbs()));
  }
  for (int i = 0; i < nb; ++i) {
    const Vec3d r = b[i] - origin;
    min_b = std::min(min_b, axis.dot(r));
    scale = std::max(scale, weight.dot(r.cwiseAbs()));
  }
  if (!(scale > kUnderflow) || !std::isfinite(scale)) return false;
  const double bound = 2e-15 * scale;
  // strict: every point must be clear of the plane through origin itself (which both triangles share).
  return strict ? max_a < -bound && min_b > bound : min_b - max_a > 2 * bound;
}

bool meetBeyondSharedEdge(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  // Folded over means: the normals of (a,b,c) and (a,b,d) point the same way. A clear angle between them settles it.
  const Vec3d u = b - a, v = c - a, w = d - a;
  const Vec3d n1 = u.cross(v), n2 = u.cross(w);
  // In squares, which need no roots: both normals are known well enough, and their cosine is below 0.9.
  const double l1 = n1.squaredNorm(), l2 = n2.squaredNorm(), uu = u.squaredNorm(), cosine = n1.dot(n2);
  if (l1 > 1e-20 * uu * v.squaredNorm() && l2 > 1e-20 * uu * w.squaredNorm() && l1 > kUnderflow && l2 > kUnderflow &&
      (cosine < 0 || cosine * cosine < 0.81 * l1 * l2))
    return false;
  if (certainSide(a, b, c, d) != 0) return false;
  const Point pa = exactPoint(a), pb = exactPoint(b), pc = exactPoint(c), pd = exactPoint(d);
  if (CGAL::orientation(pa, pb, pc, pd) != CGAL::COPLANAR) return false;
  return CGAL::coplanar_orientation(pa, pb, pc, pd) == CGAL::POSITIVE;
}

// Triangles (v,a1,a2) and (v,b1,b2): if they meet elsewhere, the edge opposite v of one of them reaches the other.
bool meetBeyondSharedVertex(const Vec3d& v, const Vec3d (&a)[2], const Vec3d (&b)[2]) {
  // Any axis will do that separates them: of edges about as long the plain sum does, sooner.
  if (separates((b[0] + b[1]) - (a[0] + a[1]), v, a, 2, b, 2, true)) return false;
  const Vec3d middle_a = (a[0] - v).normalized() + (a[1] - v).normalized();
  const Vec3d middle_b = (b[0] - v).normalized() + (b[1] - v).normalized();
  if (separates(middle_b - middle_a, v, a, 2, b, 2, true)) return false;
  if (certainSide(v, a[0], a[1], b[0]) * certainSide(v, a[0], a[1], b[1]) > 0) return false;
  if (certainSide(v, b[0], b[1], a[0]) * certainSide(v, b[0], b[1], a[1]) > 0) return false;
  const Point pv = exactPoint(v), a0 = exactPoint(a[0]), a1 = exactPoint(a[1]), b0 = exactPoint(b[0]),
              b1 = exactPoint(b[1]);
  return CGAL::do_intersect(Kernel::Segment_3(a0, a1), Kernel::Triangle_3(pv, b0, b1)) ||
         CGAL::do_intersect(Kernel::Segment_3(b0, b1), Kernel::Triangle_3(pv, a0, a1));
}

bool onOneSide(const Corners& a, const Corners& b) {
  const int s = certainSide(a[0], a[1], a[2], b[0]);
  return s != 0 && certainSide(a[0], a[1], a[2], b[1]) == s && certainSide(a[0], a[1], a[2], b[2]) == s;
}

bool meetAnywhere(const Corners& a, const Corners& b) {
  const Vec3d apart = (b[0] + b[1] + b[2]) - (a[0] + a[1] + a[2]);
  if (separates(apart, a[0], a.data(), 3, b.data(), 3, false)) return false;
  if (onOneSide(a, b) || onOneSide(b, a)) return false;
  // Nearly coplanar neighbours: try the walls standing on the edges, facing outwards.
  const Vec3d normal_a = (a[1] - a[0]).cross(a[2] - a[0]), normal_b = (b[1] - b[0]).cross(b[2] - b[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t n = (k + 1) % 3;
    if (separates((a[n] - a[k]).cross(normal_a), a[k], a.data(), 3, b.data(), 3, false)) return false;
    if (separates((b[n] - b[k]).cross(normal_b), b[k], b.data(), 3, a.data(), 3, false)) return false;
  }
  return CGAL::do_intersect(Kernel::Triangle_3(exactPoint(a[0]), exactPoint(a[1]), exactPoint(a[2])),
                            Kernel::Triangle_3(exactPoint(b[0]), exactPoint(b[1]), exactPoint(b[2])));
}

bool meet(std::span<const Vec3d> vertices, const Triangle& s, const Triangle& t) {
  // Corners of s and t that are shared come first in order_s, order_t.
  std::array<std::size_t, 3> order_s{}, order_t{};
  std::array<bool, 3> used_s{}, used_t{};
  std::size_t shared = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (s[i] == t[j]) {
        order_s[shared] = i;
        order_t[shared] = j;
        used_s[i] = used_t[j] = true;
        ++shared;
      }

  if (shared == 3) return true;
  if (shared == 0)
    return meetAnywhere({vertices[s[0]], vertices[s[1]], vertices[s[2]]},
                        {vertices[t[0]], vertices[t[1]], vertices[t[2]]});

  for (std::size_t i = 0, ns = shared, nt = shared; i < 3; ++i) {
    if (!used_s[i]) order_s[ns++] = i;
    if (!used_t[i]) order_t[nt++] = i;
  }
  if (shared == 2)
    return meetBeyondSharedEdge(vertices[s[order_s[0]]], vertices[s[order_s[1]]], vertices[s[order_s[2]]],
                                vertices[t[order_t[2]]]);
  return meetBeyondSharedVertex(vertices[s[order_s[0]]], {vertices[s[order_s[1]]], vertices[s[order_s[2]]]},
                                {vertices[t[order_t[1]]], vertices[t[order_t[2]]]});
}

// Boxes in float, rounded outwards: half the memory of double, and a slightly larger box only costs time.
struct Box {
  std::array<float, 3> min{HUGE_VALF, HUGE_VALF, HUGE_VALF}, max{-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};

  void add(const Box& b) {
    for (std::size_t k = 0; k < 3; ++k) {
      min[k] = std::min(min[k], b.min[k]);
      max[k] = std::max(max[k], b.max[k]);
    }
  }
  bool overlaps(const Box& b) const {
    return (min[0] <= b.max[0]) & (b.min[0] <= max[0]) & (min[1] <= b.max[1]) & (b.min[1] <= max[1]) &
           (min[2] <= b.max[2]) & (b.min[2] <= max[2]);
  }
};

Box boxOf(std::span<const Vec3d> vertices, const Triangle& t) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    const auto [lo, hi] = std::minmax({vertices[t[0]][k], vertices[t[1]][k], vertices[t[2]][k]});
    auto l = static_cast<float>(lo), h = static_cast<float>(hi);
    if (l > lo) l = std::nextafter(l, -HUGE_VALF);
    if (h < hi) h = std::nextafter(h, HUGE_VALF);
    box.min[static_cast<std::size_t>(k)] = l;
    box.max[static_cast<std::size_t>(k)] = h;
  }
  return box;
}

std::uint64_t spread(std::uint64_t x) {  // two zero bits between the low 21 bits
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffffull;
  x = (x | x << 16) & 0x1f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

// Implicit tree, four children per node, over triangles in Morton order. Level 0 holds the triangles themselves.
struct Tree {
  std::vector<std::uint32_t> triangle;  // Morton order -> triangle
  std::vector<std::vector<Box>> level;  // level[k][i] bounds level[k-1][4i .. 4i+3]
};

Tree buildTree(std::span<const Vec3d> vertices, std::span<const Triangle> triangles,
               const std::vector<std::uint32_t>& active) {
  Box3 all;
  for (const std::uint32_t t : active)
    for (const std::uint32_t v : triangles[t]) all.add(vertices[v]);

  // The triangles in Morton order of their centres.
  Vec3d scale = Vec3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (const double s = 2097151.0 / (all.max[k] - all.min[k]); std::isfinite(s)) scale[k] = s;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(active.size());
  tbb::parallel_for(std::size_t{0}, active.size(), [&](std::size_t i) {
    const Triangle& t = triangles[active[i]];
    const Vec3d c = vertices[t[0]] / 3 + vertices[t[1]] / 3 + vertices[t[2]] / 3;
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const double x = std::clamp((c[k] - all.min[k]) * scale[k], 0.0, 2097151.0);
      code |= spread(static_cast<std::uint64_t>(x)) << k;
    }
    order[i] = {code, active[i]};
  });
  tbb::parallel_sort(order.begin(), order.end());

  Tree tree;
  tree.triangle.resize(order.size());
  tree.level.emplace_back(order.size());
  tbb::parallel_for(std::size_t{0}, order.size(), [&](std::size_t i) {
    tree.triangle[i] = order[i].second;
    tree.level[0][i] = boxOf(vertices, triangles[order[i].second]);
  });

  while (tree.level.back().size() > 1) {
    const std::vector<Box>& below = tree.level.back();
    std::vector<Box> here((below.size() + 3) / 4);
    for (std::size_t i = 0; i < below.size(); ++i) here[i / 4].add(below[i]);
    tree.level.push_back(std::move(here));
  }
  return tree;
}

// Until `out` has enough: appends the pairs of leaf group `g` (triangles 4g .. 4g+3 in Morton order) with itself and
// everything behind it.
void pairsOfGroup(const Tree& tree, std::span<const Vec3d> vertices, std::span<const Triangle> triangles, std::size_t g,
                  std::size_t enough, std::vector<Pair>& out) {
  const std::vector<Box>& leaf = tree.level[0];
  const std::size_t begin = 4 * g, end = std::min(begin + 4, leaf.size());
  const Box& box = tree.level[1][g];

  struct Node {
    std::size_t level, index;
  };
  std::array<Node, 128> stack;  // depth <= 16 levels, at most 3 waiting nodes per level
  std::size_t top = 0;
  stack[top++] = {tree.level.size() - 1, 0};

  while (top > 0 && out.size() < enough) {
    const Node node = stack[--top];

    if (node.level == 1) {
      const std::size_t first = 4 * node.index, last = std::min(first + 4, leaf.size());
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t j = std::max(first, i + 1); j < last; ++j)
          if (leaf[i].overlaps(leaf[j])) {
            const std::uint32_t s = tree.triangle[i], t = tree.triangle[j];
            if (meet(vertices, triangles[s], triangles[t])) out.emplace_back(std::min(s, t), std::max(s, t));
          }
      continue;
    }

    const std::size_t below = node.level - 1;
    const std::vector<Box>& boxes = tree.level[below];
    const std::size_t first = 4 * node.index, last = std::min(first + 4, boxes.size());
    const std::size_t shift = 2 * (below - 1);  // groups under a node of this level
    for (std::size_t c = first; c < last; ++c)
      if (((c + 1) << shift) > g && boxes[c].overlaps(box)) stack[top++] = {below, c};
  }
}

// The triangles with area, in order.
std::vector<std::uint32_t> properTriangles(std::span<const Vec3d> vertices, std::span<const Triangle> triangles) {
  std::vector<std::uint32_t> out;
  out.reserve(triangles.size());
  const std::vector<std::uint32_t> flat = degenerateTriangles(vertices, triangles);
  for (std::size_t t = 0, f = 0; t < triangles.size(); ++t)
    if (f < flat.size() && flat[f] == t)
      ++f;
    else
      out.push_back(static_cast<std::uint32_t>(t));
  return out;
}

// Appends the pairs of triangle `t` with those of the tree. Two triangles of the tree are one pair: that of the larger.
void pairsOfTriangle(const Tree& tree, std::span<const Vec3d> vertices, std::span<const Triangle> triangles,
                     std::uint32_t t, bool is_in_tree, std::vector<Pair>& out) {
  const Box box = boxOf(vertices, triangles[t]);
  const auto visit = [&](const auto& self, std::size_t level, std::size_t index) -> void {
    if (!tree.level[level][index].overlaps(box)) return;
    if (level > 0) {
      const std::size_t last = std::min(4 * index + 4, tree.level[level - 1].size());
      for (std::size_t child = 4 * index; child < last; ++child) self(self, level - 1, child);
      return;
    }
    const std::uint32_t s = tree.triangle[index];
    if (s == t || (is_in_tree && s > t)) return;
    if (meet(vertices, triangles[s], triangles[t])) out.emplace_back(std::min(s, t), std::max(s, t));
  };
  visit(visit, tree.level.size() - 1, 0);
}

}  // namespace

std::vector<std::uint32_t> degenerateTriangles(std::span<const Vec3d> vertices, std::span<const Triangle> triangles) {
  std::vector<char> flat(triangles.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const Triangle& t = triangles[i];
      const Vec3d &a = vertices[t[0]], &b = vertices[t[1]], &c = vertices[t[2]];
      const Vec3d u = b - a, v = c - a;
      const double bound = u.cwiseAbs().sum() * v.cwiseAbs().sum();
      // Each component of the cross product is off by less than 8 roundings of `bound`.
      if (bound > kUnderflow && std::isfinite(bound) && u.cross(v).cwiseAbs().maxCoeff() > 1e-15 * bound) continue;
      flat[i] =
          t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || CGAL::collinear(exactPoint(a), exactPoint(b), exactPoint(c));
    }
  });
  std::vector<std::uint32_t> list;
  for (std::size_t i = 0; i < flat.size(); ++i)
    if (flat[i]) list.push_back(static_cast<std::uint32_t>(i));
  return list;
}

std::vector<Pair> selfIntersections(std::span<const Vec3d> vertices, std::span<const Triangle> triangles,
                                    std::size_t stop_after) {
  const std::vector<std::uint32_t> active = properTriangles(vertices, triangles);
  std::vector<Pair> pairs;
  if (active.size() < 2 || stop_after == 0) return pairs;
  const Tree tree = buildTree(vertices, triangles, active);

  // In rounds of blocks, so that a limited search can stop early.
  const std::size_t groups = tree.level[1].size();
  constexpr std::size_t kGrain = 256;  // fixed, so that the rounds of a limited search are the same on any machine
  const std::size_t blocks = (groups + kGrain - 1) / kGrain;
  const std::size_t round = stop_after == kAllPairs ? blocks : 8;
  std::vector<std::vector<Pair>> found(blocks);
  for (std::size_t start = 0; start < blocks && pairs.size() < stop_after; start += round) {
    const std::size_t stop = std::min(start + round, blocks);
    tbb::parallel_for(start, stop, [&](std::size_t block) {
      for (std::size_t g = block * kGrain; g < std::min((block + 1) * kGrain, groups); ++g)
        pairsOfGroup(tree, vertices, triangles, g, stop_after, found[block]);
    });
    for (std::size_t block = start; block < stop; ++block)
      pairs.insert(pairs.end(), found[block].begin(), found[block].end());
  }

  std::sort(pairs.begin(), pairs.end());
  if (pairs.size() > stop_after) pairs.resize(stop_after);
  return pairs;
}

std::vector<Pair> selfIntersectionsOf(std::span<const Vec3d> vertices, std::span<const Triangle> triangles,
                                      std::span<const char> chosen) {
  const std::vector<std::uint32_t> proper = properTriangles(vertices, triangles);
  std::vector<std::uint32_t> few;
  std::copy_if(proper.begin(), proper.end(), std::back_inserter(few), [&](std::uint32_t t) { return chosen[t] != 0; });
  std::vector<Pair> pairs;
  if (few.empty()) return pairs;
  const Tree tree = buildTree(vertices, triangles, few);

  constexpr std::size_t kGrain = 4096;
  std::vector<std::vector<Pair>> found((proper.size() + kGrain - 1) / kGrain);
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t block) {
    for (std::size_t i = block * kGrain; i < std::min((block + 1) * kGrain, proper.size()); ++i)
      pairsOfTriangle(tree, vertices, triangles, proper[i], chosen[proper[i]] != 0, found[block]);
  });
  for (const std::vector<Pair>& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace kerf
