// Segments in a plane, split where they cross, and the winding numbers of the faces between them. For the sources of
// kerf_close_exact only: it brings CGAL.
#pragma once

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_plus_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "geometry/base/types.h"
#include "preprocess/close/poll.h"

namespace kerf::internal {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_2<Kernel>;
using Face = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Cdt = CGAL::Constrained_triangulation_plus_2<CGAL::Constrained_Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>, CGAL::Exact_predicates_tag>>;
using Point2 = std::array<double, 2>;
using Segment = std::vector<Point2>;  ///< the projection of one edge, with the points inserted on it
inline constexpr int kMaxRounds = 20;

inline Point2 rounded(const Kernel::Point_2& p) { return {roundedToFloat(p.x()), roundedToFloat(p.y())}; }

/// Inserts all segments, and splits them at float32 points where they cross. True once nothing crosses; false after too
/// many rounds, or if `poll` stops it.
inline bool arrange(std::vector<Segment>& segments, Cdt& cdt, Poll& poll) {
  for (int round = 0; round < kMaxRounds; ++round) {
    cdt.clear();
    std::vector<std::pair<std::size_t, Cdt::Constraint_id>> ids;
    std::vector<std::size_t> first(segments.size() + 1);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      first[s] = ids.size();
      for (std::size_t k = 0; k + 1 < segments[s].size(); ++k) {
        if (poll.stop()) return false;
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

/// How often edges run from p to q, less how often back.
using Net = std::map<std::array<Point2, 2>, int>;

inline void count(const Segment& s, Net& net) {
  for (std::size_t k = 1; k < s.size(); ++k) {
    ++net[{s[k - 1], s[k]}];
    --net[{s[k], s[k - 1]}];
  }
}

/// Calls f(corners, winding) for every finite face: how often the edges of `net` wind around it, from the outside in.
template <class F>
void forEachFace(const Cdt& cdt, const Net& net, F&& f) {
  std::map<Cdt::Face_handle, int> winding;
  std::vector<Cdt::Face_handle> stack{cdt.infinite_face()};
  winding[cdt.infinite_face()] = 0;
  while (!stack.empty()) {
    const Cdt::Face_handle face = stack.back();
    stack.pop_back();
    for (int i = 0; i < 3; ++i) {
      const Cdt::Face_handle g = face->neighbor(i);
      if (winding.count(g)) continue;
      int w = winding[face];
      const auto a = face->vertex(Cdt::ccw(i)), b = face->vertex(Cdt::cw(i));  // the face lies left of a -> b
      if (!cdt.is_infinite(a) && !cdt.is_infinite(b)) {
        const Point2 pa{a->point().x(), a->point().y()}, pb{b->point().x(), b->point().y()};
        if (const auto it = net.find({pa, pb}); it != net.end()) w -= it->second;
      }
      winding[g] = w;
      stack.push_back(g);
    }
  }

  for (auto face = cdt.finite_faces_begin(); face != cdt.finite_faces_end(); ++face) {
    std::array<Point2, 3> corners;
    for (int k = 0; k < 3; ++k)
      corners[static_cast<std::size_t>(k)] = {face->vertex(k)->point().x(), face->vertex(k)->point().y()};
    f(corners, winding[face]);
  }
}

}  // namespace kerf::internal
