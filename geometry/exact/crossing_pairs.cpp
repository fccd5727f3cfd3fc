#include "geometry/exact/crossing_pairs.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace kerf {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;

Point point(const Vec3d& p) { return {p.x(), p.y(), p.z()}; }

bool isFlat(const Mesh& mesh, std::uint32_t t) {
  const Triangle& f = mesh.triangles[t];
  if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) return true;
  return CGAL::collinear(point(mesh.vertices[f[0]]), point(mesh.vertices[f[1]]), point(mesh.vertices[f[2]]));
}

/// The two ends of a triangle without area, as places in the triangle.
std::array<int, 2> farEnds(const Mesh& mesh, std::uint32_t t) {
  std::array<int, 2> best{0, 1};
  double longest = -1;
  for (int k = 0; k < 3; ++k) {
    const double d = (mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3)).squaredNorm();
    if (d > longest) longest = d, best = {k, (k + 1) % 3};
  }
  return best;
}

/// A triangle without area against a proper one: do they meet away from shared vertices?
bool flatMeets(const Mesh& mesh, std::uint32_t flat, std::uint32_t other) {
  const Triangle& f = mesh.triangles[flat];
  const Triangle& g = mesh.triangles[other];
  const auto shared = [&](std::uint32_t v) { return v == g[0] || v == g[1] || v == g[2]; };
  const Kernel::Triangle_3 proper(point(mesh.vertices[g[0]]), point(mesh.vertices[g[1]]), point(mesh.vertices[g[2]]));
  for (const std::uint32_t v : f)
    if (!shared(v) && proper.has_on(point(mesh.vertices[v]))) return true;
  const auto ends = farEnds(mesh, flat);
  const std::uint32_t a = f[static_cast<std::size_t>(ends[0])], b = f[static_cast<std::size_t>(ends[1])];
  if (mesh.vertices[a] == mesh.vertices[b] || shared(a) || shared(b)) return false;
  return CGAL::do_intersect(Kernel::Segment_3(point(mesh.vertices[a]), point(mesh.vertices[b])), proper);
}

bool properMeet(const Mesh& mesh, std::uint32_t i, std::uint32_t j) {
  const Triangle& f = mesh.triangles[i];
  const Triangle& g = mesh.triangles[j];
  int count = 0;
  std::array<int, 3> in_f{}, in_g{};
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      if (f[static_cast<std::size_t>(a)] == g[static_cast<std::size_t>(b)]) {
        in_f[static_cast<std::size_t>(count)] = a, in_g[static_cast<std::size_t>(count)] = b, ++count;
        break;
      }
  if (count == 3) return true;
  std::array<Point, 3> p, q;
  for (std::size_t k = 0; k < 3; ++k) p[k] = point(mesh.vertices[f[k]]), q[k] = point(mesh.vertices[g[k]]);
  const auto at = [](int k) { return static_cast<std::size_t>(k % 3); };
  if (count == 2) {
    const Point& c = p[at(3 - in_f[0] - in_f[1])];
    const Point& d = q[at(3 - in_g[0] - in_g[1])];
    const Point &a = p[at(in_f[0])], &b = p[at(in_f[1])];
    return CGAL::orientation(a, b, c, d) == CGAL::COPLANAR && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
  }
  if (count == 1) {
    const Point &f1 = p[at(in_f[0] + 1)], &f2 = p[at(in_f[0] + 2)], &g1 = q[at(in_g[0] + 1)], &g2 = q[at(in_g[0] + 2)];
    const auto s1 = CGAL::orientation(q[0], q[1], q[2], f1), s2 = CGAL::orientation(q[0], q[1], q[2], f2);
    if (s1 == s2 && s1 != CGAL::COPLANAR) return false;
    return CGAL::do_intersect(Kernel::Segment_3(f1, f2), Kernel::Triangle_3(q[0], q[1], q[2])) ||
           CGAL::do_intersect(Kernel::Segment_3(g1, g2), Kernel::Triangle_3(p[0], p[1], p[2]));
  }
  return CGAL::do_intersect(Kernel::Triangle_3(p[0], p[1], p[2]), Kernel::Triangle_3(q[0], q[1], q[2]));
}

}  // namespace

std::vector<std::array<std::uint32_t, 2>> crossingPairs(const Mesh& mesh, const std::vector<char>& only) {
  const auto n = static_cast<std::uint32_t>(mesh.triangles.size());
  std::vector<char> flat(n);
  std::vector<Box> boxes(n);
  tbb::parallel_for(std::uint32_t{0}, n, [&](std::uint32_t t) {
    flat[t] = isFlat(mesh, t);
    CGAL::Bbox_3 box;
    for (int k = 0; k < 3; ++k) box += point(mesh.corner(t, k)).bbox();
    boxes[t] = Box(box, t);
  });
  std::vector<std::array<std::uint32_t, 2>> pairs;
  const auto collect = [&](const Box& a, const Box& b) {
    const std::uint32_t i = std::min(a.info(), b.info()), j = std::max(a.info(), b.info());
    if (flat[i] && flat[j]) return;
    pairs.push_back({i, j});
  };
  if (only.empty()) {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), collect);
  } else {
    std::vector<Box> some;
    for (std::uint32_t t = 0; t < n; ++t)
      if (only[t]) some.push_back(boxes[t]);
    CGAL::box_intersection_d(some.begin(), some.end(), boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
      if (a.info() != b.info()) collect(a, b);
    });
  }
  std::vector<char> hit(pairs.size());
  tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
    const auto [i, j] = pairs[k];
    hit[k] = flat[i] ? flatMeets(mesh, i, j) : flat[j] ? flatMeets(mesh, j, i) : properMeet(mesh, i, j);
  });
  std::size_t kept = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (hit[k]) pairs[kept++] = pairs[k];
  pairs.resize(kept);
  for (std::uint32_t t = 0; t < n; ++t)
    if (flat[t] && (only.empty() || only[t])) pairs.push_back({t, t});
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace kerf
