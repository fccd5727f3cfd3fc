#include "preprocess/close/stitch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

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

/// The open vertices, in cubes.
class Grid {
 public:
  Grid(const Mesh& mesh, const std::vector<OpenEdge>& edges, double cell) : mesh_(mesh), cell_(cell) {
    for (const std::uint32_t v : openVertices(edges)) cubes_[cube(mesh.vertices[v])].push_back(v);
  }
  /// Calls f for the open vertices in a box, in order.
  template <class F>
  void forEachIn(Box3 box, double margin, F&& f) const {
    box.grow(margin);
    const Cube low = cube(box.min), high = cube(box.max);
    for (long x = low[0]; x <= high[0]; ++x)
      for (long y = low[1]; y <= high[1]; ++y)
        for (long z = low[2]; z <= high[2]; ++z)
          if (const auto it = cubes_.find({x, y, z}); it != cubes_.end())
            for (const std::uint32_t v : it->second)
              if (box.contains(mesh_.vertices[v])) f(v);
  }

 private:
  using Cube = std::array<long, 3>;
  Cube cube(const Vec3d& p) const {
    return {std::lround(std::floor(p[0] / cell_)), std::lround(std::floor(p[1] / cell_)),
            std::lround(std::floor(p[2] / cell_))};
  }
  const Mesh& mesh_;
  double cell_;
  std::map<Cube, std::vector<std::uint32_t>> cubes_;
};

/// Mean length of the open edges, at least twice the tolerance: a good size for the cubes.
double cellSize(const Mesh& mesh, const std::vector<OpenEdge>& edges, double tolerance) {
  double sum = 0;
  for (const OpenEdge& e : edges) sum += (mesh.vertices[e.a] - mesh.vertices[e.b]).norm();
  return std::max(2 * tolerance, sum / static_cast<double>(edges.size()));
}

struct Done {
  std::size_t joined = 0, split = 0;
  double move = 0;
};

/// Two open vertices that may be joined; first < second.
struct Pair {
  double distance;
  std::uint32_t first, second;
};

/// Those no farther apart than the tolerance, the closest first.
std::vector<Pair> closePairs(const Mesh& mesh, const std::vector<OpenEdge>& edges, double tolerance) {
  const Grid grid(mesh, edges, cellSize(mesh, edges, tolerance));
  std::vector<Pair> pairs;
  for (const std::uint32_t v : openVertices(edges)) {
    Box3 box;
    box.add(mesh.vertices[v]);
    grid.forEachIn(box, tolerance, [&](std::uint32_t w) {
      const double d = (mesh.vertices[v] - mesh.vertices[w]).norm();
      if (w > v && d <= tolerance) pairs.push_back({d, v, w});
    });
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) {
    if (x.distance != y.distance) return x.distance < y.distance;
    return x.first != y.first ? x.first < y.first : x.second < y.second;
  });
  return pairs;
}

/// The closest pairs first; a vertex takes part in one join.
void joinVertices(Chain& chain, const std::vector<OpenEdge>& edges, double tolerance, Done& done) {
  Mesh& mesh = chain.mesh;
  const std::vector<Pair> pairs = closePairs(mesh, edges, tolerance);
  std::map<std::uint32_t, std::vector<std::uint32_t>> neighbours;  // of the vertices in pairs
  for (const Pair& p : pairs) {
    neighbours.try_emplace(p.first);
    neighbours.try_emplace(p.second);
  }
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f)
      if (const auto it = neighbours.find(v); it != neighbours.end())
        it->second.insert(it->second.end(), f.begin(), f.end());

  std::vector<std::uint32_t> target(mesh.vertices.size());
  std::iota(target.begin(), target.end(), 0u);
  std::vector<char> taken(mesh.vertices.size(), 0);
  for (const Pair& p : pairs) {
    if (taken[p.first] || taken[p.second]) continue;
    const auto& around = neighbours[p.second];
    // Two ends of one edge: joining them would lose a triangle.
    if (std::find(around.begin(), around.end(), p.first) != around.end()) continue;
    taken[p.first] = taken[p.second] = 1;
    target[p.second] = p.first;
    ++done.joined;
    done.move = std::max(done.move, p.distance);
  }

  for (Triangle& f : mesh.triangles)
    for (std::uint32_t& v : f) v = target[v];
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

/// One per triangle at most.
std::vector<Cut> cutsNear(const Mesh& mesh, const std::vector<OpenEdge>& edges, double tolerance) {
  const Grid grid(mesh, edges, cellSize(mesh, edges, tolerance));
  std::vector<Cut> cuts;
  std::vector<char> taken(mesh.triangles.size(), 0);
  for (const OpenEdge& e : edges) {
    if (taken[e.triangle]) continue;
    const Vec3d a = mesh.vertices[e.a], d = mesh.vertices[e.b] - a;
    const std::uint32_t apex = mesh.triangles[e.triangle][(e.corner + 2) % 3];
    Box3 box;
    box.add(a);
    box.add(mesh.vertices[e.b]);

    std::vector<Cut::Stop> stops;
    grid.forEachIn(box, tolerance, [&](std::uint32_t v) {
      if (v == e.a || v == e.b || v == apex) return;
      const double s = (mesh.vertices[v] - a).dot(d) / d.squaredNorm();
      if (s > 0 && s < 1 && (mesh.vertices[v] - a - s * d).norm() <= tolerance) stops.push_back({s, v});
    });
    if (stops.empty()) continue;

    std::sort(stops.begin(), stops.end(),
              [](const Cut::Stop& x, const Cut::Stop& y) { return x.at != y.at ? x.at < y.at : x.v < y.v; });
    taken[e.triangle] = 1;
    cuts.push_back({e, std::move(stops)});
  }
  return cuts;
}

/// Splits every open edge at the open vertices near it, one edge per triangle. True if any was.
bool splitEdges(Chain& chain, double tolerance, Done& done) {
  Mesh& mesh = chain.mesh;
  const std::vector<OpenEdge> edges = openEdges(mesh.triangles);
  if (edges.empty()) return false;
  const std::vector<Cut> cuts = cutsNear(mesh, edges, tolerance);

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

void stitchSeams(Chain& chain, double tolerance, CloseReport& report) {
  const std::vector<OpenEdge> edges = openEdges(chain.mesh.triangles);
  if (edges.empty() || !(tolerance > 0)) return;
  Done done;
  joinVertices(chain, edges, tolerance, done);
  for (int round = 0; round < kMostRounds && splitEdges(chain, tolerance, done); ++round) {
  }
  if (done.joined + done.split == 0) return;
  report.seam_vertices = done.joined + done.split;
  report.vertices_moved += done.joined;
  report.largest_move_mm = std::max(report.largest_move_mm, done.move);
  report.changes.push_back(
      fmt::format("seams were stitched within {:.2g} mm: {} joined, {} split at one (moved by {:.2g} mm at most)",
                  tolerance, counted(done.joined, "pair of boundary vertices was", "pairs of boundary vertices were"),
                  counted(done.split, "boundary edge was", "boundary edges were"), done.move));
}

}  // namespace kerf::internal
