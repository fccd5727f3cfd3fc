#include "preprocess/close/base.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_plus_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/convex_hull_2.h>

#include <map>

#include "geometry/mesh/float32_cleanup.h"
#include "preprocess/close/poll.h"

namespace kerf::internal {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_2<Kernel>;
using Face = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Cdt = CGAL::Constrained_triangulation_plus_2<CGAL::Constrained_Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>, CGAL::Exact_predicates_tag>>;
using Point2 = std::array<double, 2>;
using Segment = std::vector<Point2>;  ///< the projection of one edge, with the points inserted on it
constexpr int kMaxRounds = 20;

Point2 rounded(const Kernel::Point_2& p) { return {roundedToFloat(p.x()), roundedToFloat(p.y())}; }

/// Inserts all segments, and splits them at float32 points where they cross. True once nothing crosses; false after too
/// many rounds, or if `poll` stops it.
bool arrange(std::vector<Segment>& segments, Cdt& cdt, Poll& poll) {
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

void count(const Segment& s, Net& net) {
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

/// The vertices of one plane of the base.
class Floor {
 public:
  Floor(Chain& chain, const BaseFrame& frame, double level) : chain_(chain), frame_(frame), level_(level) {}

  /// Two points of the plane with equal float32 coordinates in space are one vertex.
  std::uint32_t vertex(const Point2& p) {
    const Vec3d x = roundedToFloat(Vec3d(Vec3d::Zero() + level_ * frame_.w + p[0] * frame_.u + p[1] * frame_.v));
    const auto [it, fresh] = vertex_at_.try_emplace({x.x(), x.y(), x.z()}, 0);
    if (fresh) it->second = chain_.addVertex(x);
    return it->second;
  }
  /// |times| copies, facing along w if times > 0.
  void addFace(const std::array<Point2, 3>& corners, int times) {
    if (times == 0) return;
    const std::uint32_t a = vertex(corners[0]), b = vertex(corners[1]), c = vertex(corners[2]);
    for (int k = 0; k < std::abs(times); ++k) times > 0 ? chain_.addTriangle(a, b, c) : chain_.addTriangle(a, c, b);
  }

 private:
  Chain& chain_;
  const BaseFrame& frame_;
  double level_;
  std::map<std::array<double, 3>, std::uint32_t> vertex_at_;
};

/// The convex outline of all points, counter-clockwise.
std::vector<Segment> convexOutline(const std::vector<Segment>& segments) {
  std::vector<Kernel::Point_2> points, hull;
  for (const Segment& s : segments)
    for (const Point2& p : s) points.push_back({p[0], p[1]});
  CGAL::convex_hull_2(points.begin(), points.end(), std::back_inserter(hull));
  std::vector<Segment> outline;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const auto &p = hull[i], &q = hull[(i + 1) % hull.size()];
    outline.push_back({{p.x(), p.y()}, {q.x(), q.y()}});
  }
  return outline;
}

/// The edges of all rims, and the shadow of each in the plane of the base.
struct Shadow {
  struct Edge {
    std::uint32_t from, to;
  };
  std::vector<Edge> edges;
  std::vector<Segment> segments;  ///< of the edges, in their order; others may follow
};

Shadow shadowOf(const Mesh& mesh, const std::vector<Loop>& rims, const BaseFrame& frame) {
  const auto project = [&](std::uint32_t v) {
    const Vec3d& p = mesh.vertices[v];
    return Point2{roundedToFloat(p.dot(frame.u)), roundedToFloat(p.dot(frame.v))};
  };
  Shadow shadow;
  for (const Loop& loop : rims)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::uint32_t p = loop[i], q = loop[(i + 1) % loop.size()];
      shadow.edges.push_back({p, q});
      Segment s{project(p)};
      if (project(q) != s[0]) s.push_back(project(q));
      shadow.segments.push_back(std::move(s));
    }
  return shadow;
}

/// Walls from the rims along w to the plane of `foot`, at `end` mm along w.
void addWalls(Chain& chain, const Shadow& shadow, const BaseFrame& frame, double end, Floor& foot) {
  std::map<std::uint32_t, std::uint32_t> under;  // per rim vertex: the vertex at the end of its colour
  const auto wallTop = [&](std::uint32_t v) {
    if (!chain.mesh.hasVertexColors()) return v;
    const auto [it, fresh] = under.try_emplace(v, 0);
    if (fresh) {
      constexpr double kFade = 0.2;  // mm
      const Vec3d x = chain.mesh.vertices[v];
      const double depth = end - x.dot(frame.w);
      it->second = chain.addVertex(roundedToFloat(Vec3d(x + std::min(kFade, depth / 2) * frame.w)));
    }
    return it->second;
  };

  for (std::size_t s = 0; s < shadow.edges.size(); ++s) {
    const auto& [rim_p, rim_q] = shadow.edges[s];
    const std::uint32_t p = wallTop(rim_p), q = wallTop(rim_q);
    if (p != rim_p) {
      chain.addTriangle(rim_p, rim_q, q);
      chain.addTriangle(rim_p, q, p);
    }

    std::vector<std::uint32_t> below;
    for (const Point2& x : shadow.segments[s]) below.push_back(foot.vertex(x));
    chain.addTriangle(p, q, below.back());
    for (std::size_t k = below.size(); k-- > 1;) chain.addTriangle(p, below[k], below[k - 1]);
  }
}

/// The walls and the underside of the plate.
void addPlate(Chain& chain, const std::vector<Segment>& outline, const Cdt& underside, const BaseFrame& frame,
              Floor& ceiling) {
  Floor floor(chain, frame, frame.level);
  Net net;
  for (const Segment& s : outline) {
    count(s, net);
    for (std::size_t k = 1; k < s.size(); ++k) {
      const std::uint32_t p = ceiling.vertex(s[k - 1]), q = ceiling.vertex(s[k]);
      const std::uint32_t below_p = floor.vertex(s[k - 1]), below_q = floor.vertex(s[k]);
      chain.addTriangle(below_q, below_p, p);
      chain.addTriangle(below_q, p, q);
    }
  }
  forEachFace(underside, net, [&](const auto& corners, int winding) { floor.addFace(corners, winding); });
}

}  // namespace

BaseFrame baseFrame(const Vec3d& w) {
  constexpr double kAxisTolerance = 1e-9;
  BaseFrame f{};
  int axis = 0;
  w.cwiseAbs().maxCoeff(&axis);
  const double sign = w[axis] < 0 ? -1 : 1;
  if ((w - sign * Vec3d::Unit(axis)).norm() < kAxisTolerance) {
    f.w = sign * Vec3d::Unit(axis);
    f.u = Vec3d::Unit((axis + (sign > 0 ? 1 : 2)) % 3);
    f.v = Vec3d::Unit((axis + (sign > 0 ? 2 : 1)) % 3);
    return f;
  }

  int least = 0;
  w.cwiseAbs().minCoeff(&least);
  f.w = w.normalized();
  f.u = (Vec3d::Unit(least) - f.w[least] * f.w).normalized();
  f.v = f.w.cross(f.u);
  return f;
}

Expected<void> extrudeToBase(Chain& chain, const std::vector<Loop>& rims, const BaseFrame& frame, bool on_plate,
                             const Progress& progress) {
  Poll poll(progress, 0.15, "building the base");
  const auto given_up = [&]() -> tl::unexpected<Error> {
    if (poll.stopped()) return cancelled();
    return fail({.code = Error::Code::kGeometry,
                 .found = "a rim whose shadow on the base plane could not be triangulated",
                 .hint = "another --base-direction, or --close wrap"});
  };

  // The shadow of the rims, triangulated.
  Shadow shadow = shadowOf(chain.mesh, rims, frame);
  Cdt cdt, underside;
  std::vector<Segment> outline;
  try {
    if (on_plate)
      for (Segment& s : convexOutline(shadow.segments)) shadow.segments.push_back(std::move(s));
    if (!arrange(shadow.segments, cdt, poll)) return given_up();
    if (cdt.dimension() < 2)
      return fail({.code = Error::Code::kGeometry,
                   .found = "a rim that the base plane sees from its edge",
                   .expected = "a rim around some area",
                   .hint = "another --base-direction, or --close wrap"});
    outline.assign(shadow.segments.begin() + static_cast<std::ptrdiff_t>(shadow.edges.size()), shadow.segments.end());
    std::vector<Segment> again = outline;
    if (on_plate && (!arrange(again, underside, poll) || again != outline)) return given_up();
  } catch (const std::exception&) {
    return given_up();
  }

  // The walls.
  const double end = on_plate ? frame.ceiling : frame.level;
  Floor foot(chain, frame, end);
  addWalls(chain, shadow, frame, end, foot);
  Net net;
  for (std::size_t s = 0; s < shadow.edges.size(); ++s) count(shadow.segments[s], net);
  if (!on_plate) {
    forEachFace(cdt, net, [&](const auto& corners, int winding) { foot.addFace(corners, winding); });
    return {};
  }

  // The plate's upper side, without the footprint of the arch.
  Net outline_net;
  for (const Segment& s : outline) count(s, outline_net);
  for (const auto& [edge, times] : net) outline_net[edge] -= times;
  forEachFace(cdt, outline_net, [&](const auto& corners, int winding) { foot.addFace(corners, -winding); });
  addPlate(chain, outline, underside, frame, foot);
  return {};
}

}  // namespace kerf::internal
