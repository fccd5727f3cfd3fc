#include "preprocess/close/base.h"

#include <CGAL/convex_hull_2.h>

#include <map>

#include "preprocess/close/plane_arrangement.h"
#include "preprocess/close/poll.h"

namespace kerf::internal {
namespace {

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
