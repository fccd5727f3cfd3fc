#include "preprocess/internal/base.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_plus_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <map>

#include "geometry/float32_cleanup.h"

namespace kerf::internal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_2<Kernel>;
using Face = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Cdt = CGAL::Constrained_triangulation_plus_2<CGAL::Constrained_Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>, CGAL::Exact_predicates_tag>>;
using Point2 = std::array<double, 2>;
using Segment = std::vector<Point2>;  ///< the projection of one rim edge, with the points inserted on it
constexpr int kMaxRounds = 20;

Point2 rounded(const Kernel::Point_2& p) { return {roundedToFloat(p.x()), roundedToFloat(p.y())}; }

/// Inserts all segments; where they cross, splits them at float32 points. True when nothing crosses any more.
bool arrange(std::vector<Segment>& segments, Cdt& cdt) {
  for (int round = 0; round < kMaxRounds; ++round) {
    cdt.clear();
    std::vector<std::pair<std::size_t, Cdt::Constraint_id>> ids;
    std::vector<std::size_t> first(segments.size() + 1);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      first[s] = ids.size();
      for (std::size_t k = 0; k + 1 < segments[s].size(); ++k) {
        const Point2 &p = segments[s][k], &q = segments[s][k + 1];
        ids.push_back({s, cdt.insert_constraint(Kernel::Point_2(p[0], p[1]), Kernel::Point_2(q[0], q[1]))});
      }
    }
    first.back() = ids.size();
    bool changed = false;
    std::vector<Segment> next(segments.size());
    for (std::size_t s = 0; s < segments.size(); ++s) {
      next[s].push_back(segments[s][0]);
      for (std::size_t i = first[s], k = 0; i < first[s + 1]; ++i, ++k) {
        std::vector<Point2> line;
        for (auto v = cdt.vertices_in_constraint_begin(ids[i].second);
             v != cdt.vertices_in_constraint_end(ids[i].second); ++v) {
          const Point2 exact{(*v)->point().x(), (*v)->point().y()};
          line.push_back(rounded((*v)->point()));
          changed = changed || line.back() != exact;
        }
        if (line.front() != segments[s][k]) std::reverse(line.begin(), line.end());
        changed = changed || line.size() != 2;
        for (std::size_t m = 1; m < line.size(); ++m)
          if (line[m] != next[s].back()) next[s].push_back(line[m]);
      }
    }
    segments = std::move(next);
    if (!changed) return true;
  }
  return false;
}

}  // namespace

bool extrudeToBase(Chain& chain, const std::vector<Loop>& rims, int axis, int outward, double level) {
  // (u, v) such that u x v points outwards: a counter-clockwise cap then faces outwards.
  const int u = outward > 0 ? (axis + 1) % 3 : (axis + 2) % 3, v = outward > 0 ? (axis + 2) % 3 : (axis + 1) % 3;
  struct Edge {
    std::uint32_t from, to;
  };
  std::vector<Edge> edges;
  std::vector<Segment> segments;
  for (const Loop& loop : rims)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::uint32_t p = loop[i], q = loop[(i + 1) % loop.size()];
      const Vec3d &a = chain.mesh.vertices[p], &b = chain.mesh.vertices[q];
      edges.push_back({p, q});
      Segment s{{a[u], a[v]}};
      if (a[u] != b[u] || a[v] != b[v]) s.push_back({b[u], b[v]});
      segments.push_back(std::move(s));
    }
  Cdt cdt;
  try {
    if (!arrange(segments, cdt)) return false;
  } catch (const std::exception&) {
    return false;
  }
  std::map<Point2, std::uint32_t> bottom;
  const auto bottomVertex = [&](const Point2& p) {
    const auto [it, fresh] = bottom.try_emplace(p, 0);
    if (fresh) {
      Vec3d x;
      x[axis] = level, x[u] = p[0], x[v] = p[1];
      it->second = chain.addVertex(x);
    }
    return it->second;
  };
  std::map<std::array<Point2, 2>, int> net;  // how often the walls' lower edges, seen from the cap, run from p to q
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const auto& [p, q] = edges[s];
    std::vector<std::uint32_t> below;
    for (const Point2& x : segments[s]) below.push_back(bottomVertex(x));
    chain.addTriangle(p, q, below.back());
    for (std::size_t k = below.size(); k-- > 1;) chain.addTriangle(p, below[k], below[k - 1]);
    for (std::size_t k = 1; k < segments[s].size(); ++k) {
      ++net[{segments[s][k - 1], segments[s][k]}];
      --net[{segments[s][k], segments[s][k - 1]}];
    }
  }
  // Winding of every face, from the outside in.
  std::map<Cdt::Face_handle, int> winding;
  std::vector<Cdt::Face_handle> stack{cdt.infinite_face()};
  winding[cdt.infinite_face()] = 0;
  while (!stack.empty()) {
    const Cdt::Face_handle f = stack.back();
    stack.pop_back();
    for (int i = 0; i < 3; ++i) {
      const Cdt::Face_handle g = f->neighbor(i);
      if (winding.count(g)) continue;
      int w = winding[f];
      const auto a = f->vertex(Cdt::ccw(i)), b = f->vertex(Cdt::cw(i));  // f lies left of a -> b
      if (!cdt.is_infinite(a) && !cdt.is_infinite(b)) {
        const Point2 pa{a->point().x(), a->point().y()}, pb{b->point().x(), b->point().y()};
        if (const auto it = net.find({pa, pb}); it != net.end()) w -= it->second;
      }
      winding[g] = w;
      stack.push_back(g);
    }
  }
  for (auto f = cdt.finite_faces_begin(); f != cdt.finite_faces_end(); ++f) {
    const int w = winding[f];
    std::array<std::uint32_t, 3> id{};
    if (w == 0) continue;
    for (int k = 0; k < 3; ++k)
      id[static_cast<std::size_t>(k)] = bottomVertex({f->vertex(k)->point().x(), f->vertex(k)->point().y()});
    for (int k = 0; k < std::abs(w); ++k)
      w > 0 ? chain.addTriangle(id[0], id[1], id[2]) : chain.addTriangle(id[0], id[2], id[1]);
  }
  return true;
}

}  // namespace kerf::internal
