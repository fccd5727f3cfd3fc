#include "preprocess/close/stitch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "geometry/mesh/box_tree.h"
#include "preprocess/close/close.h"

namespace kerf::internal {
namespace {

constexpr int kMostRounds = 8;  ///< a triangle with two open edges is split in two rounds; more is rare

struct OpenEdge {
  std::uint32_t a, b, triangle;
  std::size_t corner;  ///< the edge runs from here to the next corner of the triangle
};

/// Edges that one triangle uses.
std::vector<OpenEdge> openEdges(const std::vector<Triangle>& triangles) {
  std::vector<OpenEdge> uses;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) uses.push_back({triangles[t][k], triangles[t][(k + 1) % 3], t, k});
  const auto key = [](const OpenEdge& e) { return std::pair(std::min(e.a, e.b), std::max(e.a, e.b)); };
  std::sort(uses.begin(), uses.end(), [&](const OpenEdge& x, const OpenEdge& y) {
    return key(x) != key(y) ? key(x) < key(y) : x.triangle < y.triangle;
  });
  std::vector<OpenEdge> open;
  for (std::size_t i = 0, j = 0; i < uses.size(); i = j) {
    while (j < uses.size() && key(uses[j]) == key(uses[i])) ++j;
    if (j - i == 1) open.push_back(uses[i]);
  }
  return open;
}

/// The ends of open edges, each once, in rising order.
std::vector<std::uint32_t> openVertices(const std::vector<OpenEdge>& edges) {
  std::vector<std::uint32_t> vertices;
  for (const OpenEdge& e : edges) {
    vertices.push_back(e.a);
    vertices.push_back(e.b);
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

/// The open vertices in a tree. A search costs only the vertices near its segment, for any spread of the vertices and
/// any length of open edges.
class OpenPoints {
 public:
  OpenPoints(const Mesh& mesh, const std::vector<OpenEdge>& edges)
      : vertices_(openVertices(edges)), tree_(boxesOf(mesh, vertices_)) {}
  const std::vector<std::uint32_t>& vertices() const { return vertices_; }

  /// Calls f for the open vertices within `margin` of the segment, and for some a little farther away; in no order.
  /// It stops once f returns false.
  template <class F>
  void forEachNear(const Vec3d& a, const Vec3d& b, double margin, const F& f) const {
    const Vec3d along = b - a;
    const double wide = margin * (1 + 1e-6);  // a division by a small length rounds
    tree_.visit([&](const Box3& box) { return comesInto(box, a, along, wide); },
                [&](std::uint32_t n) { return f(vertices_[n]); });
  }

 private:
  static std::vector<Box3> boxesOf(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
    std::vector<Box3> boxes(vertices.size());
    for (std::size_t n = 0; n < vertices.size(); ++n) boxes[n].add(mesh.vertices[vertices[n]]);
    return boxes;
  }

  /// Whether the segment comes into the box grown by the margin.
  static bool comesInto(const Box3& box, const Vec3d& a, const Vec3d& along, double margin) {
    double from = 0, to = 1;
    for (int k = 0; k < 3; ++k) {
      const double low = box.min[k] - margin - a[k], high = box.max[k] + margin - a[k];
      if (along[k] == 0) {
        if (low > 0 || high < 0) return false;
        continue;
      }
      const double x = low / along[k], y = high / along[k];
      from = std::max(from, std::min(x, y));
      to = std::min(to, std::max(x, y));
    }
    return from <= to;
  }

  std::vector<std::uint32_t> vertices_;
  BoxTree tree_;
};

struct Done {
  std::size_t joined = 0, split = 0;
  double move = 0;
};

/// Two open vertices that may be joined; first < second.
struct Pair {
  double distance;
  std::uint32_t first, second;
};

/// More than that near each other are no seams.
constexpr std::size_t kMostPairs = 2'000'000;

Error heap(std::size_t limit, const char* what, double tolerance) {
  Error e;
  e.code = Error::Code::kGeometry;
  e.found = fmt::format("more than {} {} within {:.2g} mm of each other", limit, what, tolerance);
  e.expected = "a surface with seams, not a heap of triangles";
  e.hint = "--stitch-mm 0, which joins nothing, or repair the mesh in another program";
  return e;
}

/// Those no farther apart than the tolerance, the closest first.
Expected<std::vector<Pair>> closePairs(const Mesh& mesh, const std::vector<OpenEdge>& edges, double tolerance) {
  const OpenPoints points(mesh, edges);
  std::vector<Pair> pairs;
  for (const std::uint32_t v : points.vertices()) {
    points.forEachNear(mesh.vertices[v], mesh.vertices[v], tolerance, [&](std::uint32_t w) {
      const double d = (mesh.vertices[v] - mesh.vertices[w]).norm();
      if (w > v && d <= tolerance) pairs.push_back({d, v, w});
      return pairs.size() <= kMostPairs;
    });
    if (pairs.size() > kMostPairs) return fail(heap(kMostPairs, "pairs of boundary vertices", tolerance));
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) {
    if (x.distance != y.distance) return x.distance < y.distance;
    return x.first != y.first ? x.first < y.first : x.second < y.second;
  });
  return pairs;
}

/// Per vertex in pairs: the corners of its triangles, sorted.
using SeamNeighbours = std::map<std::uint32_t, std::vector<std::uint32_t>>;

SeamNeighbours neighboursOf(const Mesh& mesh, const std::vector<Pair>& pairs) {
  SeamNeighbours neighbours;
  for (const Pair& p : pairs) {
    neighbours.try_emplace(p.first);
    neighbours.try_emplace(p.second);
  }
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f)
      if (const auto it = neighbours.find(v); it != neighbours.end())
        it->second.insert(it->second.end(), f.begin(), f.end());
  for (auto& [v, around] : neighbours) std::sort(around.begin(), around.end());
  return neighbours;
}

/// The closest pairs first; a vertex takes part in one join.
Expected<void> joinVertices(Chain& chain, const std::vector<OpenEdge>& edges, double tolerance, Done& done) {
  Mesh& mesh = chain.mesh;
  KERF_TRY(pairs, closePairs(mesh, edges, tolerance));
  if (pairs.empty()) return {};
  const SeamNeighbours neighbours = neighboursOf(mesh, pairs);

  std::vector<std::uint32_t> target(mesh.vertices.size());
  std::iota(target.begin(), target.end(), 0u);
  std::vector<char> taken(mesh.vertices.size(), 0);
  for (const Pair& p : pairs) {
    if (taken[p.first] || taken[p.second]) continue;
    const auto& around = neighbours.at(p.second);
    // Two ends of one edge: joining them would lose a triangle.
    if (std::binary_search(around.begin(), around.end(), p.first)) continue;
    taken[p.first] = taken[p.second] = 1;
    target[p.second] = p.first;
    ++done.joined;
    done.move = std::max(done.move, p.distance);
  }

  for (Triangle& f : mesh.triangles)
    for (std::uint32_t& v : f) v = target[v];
  return {};
}

/// An open edge, and the open vertices near it in their order along it.
struct Cut {
  struct Stop {
    double at;  ///< share of the edge
    std::uint32_t v;
  };
  OpenEdge edge;
  std::vector<Stop> stops;
};

/// More vertices on edges, in all rounds, are no seams: each split makes edges that others may lie on.
constexpr std::size_t kMostStops = 200'000;

/// One per triangle at most.
/// @param found  how many there were in earlier rounds.
Expected<std::vector<Cut>> cutsNear(const Mesh& mesh, const std::vector<OpenEdge>& edges, double tolerance,
                                    std::size_t found) {
  const OpenPoints points(mesh, edges);
  std::vector<Cut> cuts;
  std::vector<char> taken(mesh.triangles.size(), 0);
  for (const OpenEdge& e : edges) {
    if (taken[e.triangle]) continue;
    const Vec3d a = mesh.vertices[e.a], d = mesh.vertices[e.b] - a;
    const std::uint32_t apex = mesh.triangles[e.triangle][(e.corner + 2) % 3];

    std::vector<Cut::Stop> stops;
    points.forEachNear(a, mesh.vertices[e.b], tolerance, [&](std::uint32_t v) {
      if (v == e.a || v == e.b || v == apex) return true;
      const double s = (mesh.vertices[v] - a).dot(d) / d.squaredNorm();
      if (s > 0 && s < 1 && (mesh.vertices[v] - a - s * d).norm() <= tolerance) stops.push_back({s, v});
      return found + stops.size() <= kMostStops;
    });
    if (stops.empty()) continue;
    found += stops.size();
    if (found > kMostStops) return fail(heap(kMostStops, "boundary vertices and edges", tolerance));

    std::sort(stops.begin(), stops.end(),
              [](const Cut::Stop& x, const Cut::Stop& y) { return x.at != y.at ? x.at < y.at : x.v < y.v; });
    taken[e.triangle] = 1;
    cuts.push_back({e, std::move(stops)});
  }
  return cuts;
}

/// Splits every open edge at the open vertices near it, one edge per triangle. True if any was.
Expected<bool> splitSeamEdges(Chain& chain, double tolerance, Done& done) {
  Mesh& mesh = chain.mesh;
  const std::vector<OpenEdge> edges = openEdges(mesh.triangles);
  if (edges.empty()) return false;
  KERF_TRY(cuts, cutsNear(mesh, edges, tolerance, done.split));

  for (const Cut& cut : cuts) {
    const Triangle f = mesh.triangles[cut.edge.triangle];
    const std::uint32_t apex = f[(cut.edge.corner + 2) % 3];
    const Vec3d a = mesh.vertices[cut.edge.a], d = mesh.vertices[cut.edge.b] - a;

    std::uint32_t from = cut.edge.a;
    for (std::size_t i = 0; i <= cut.stops.size(); ++i) {
      const std::uint32_t to = i < cut.stops.size() ? cut.stops[i].v : cut.edge.b;
      if (i < cut.stops.size()) {
        done.move = std::max(done.move, (mesh.vertices[to] - a - cut.stops[i].at * d).norm());
        ++done.split;
      }
      if (i == 0) {
        mesh.triangles[cut.edge.triangle] = {from, to, apex};
      } else {
        mesh.triangles.push_back({from, to, apex});
        chain.source.push_back(std::uint32_t(chain.source[cut.edge.triangle]));
        if (mesh.hasFaceColors()) mesh.face_colors.push_back(Rgba8(mesh.face_colors[cut.edge.triangle]));
      }
      from = to;
    }
  }
  return !cuts.empty();
}

}  // namespace

Expected<void> stitchSeams(Chain& chain, double tolerance, CloseReport& report) {
  const std::vector<OpenEdge> edges = openEdges(chain.mesh.triangles);
  if (edges.empty() || !(tolerance > 0)) return {};
  Done done;
  KERF_CHECK(joinVertices(chain, edges, tolerance, done));
  for (int round = 0; round < kMostRounds; ++round) {
    KERF_TRY(any, splitSeamEdges(chain, tolerance, done));
    if (!any) break;
  }
  if (done.joined + done.split == 0) return {};
  report.seam_vertices = done.joined + done.split;
  report.vertices_moved += done.joined;
  report.largest_move_mm = std::max(report.largest_move_mm, done.move);
  report.changes.push_back(
      fmt::format("seams were stitched within {:.2g} mm: {} joined, {} split at one (moved by {:.2g} mm at most)",
                  tolerance, counted(done.joined, "pair of boundary vertices was", "pairs of boundary vertices were"),
                  counted(done.split, "boundary edge was", "boundary edges were"), done.move));
  return {};
}

}  // namespace kerf::internal
