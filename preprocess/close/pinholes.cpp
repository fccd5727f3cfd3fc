#include "preprocess/close/pinholes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <unordered_map>

#include "geometry/mesh/float32_cleanup.h"
#include "preprocess/close/edges.h"
#include "preprocess/close/winding.h"

namespace kerf::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNoEdge = std::numeric_limits<std::uint32_t>::max();

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// False if they were joined already.
  bool join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a == b) return false;
    parent_[std::max(a, b)] = std::min(a, b);
    return true;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// The edges of a closed manifold, and which of them meet at each vertex.
class Graph {
 public:
  struct Edge {
    std::uint32_t a, b;
    std::array<std::uint32_t, 2> triangles;
    double length;
  };

  explicit Graph(const Mesh& mesh) : triangles_(mesh.triangles.size()) {
    forEachEdge(edgeUses(mesh.triangles), [&](std::span<const EdgeUse> uses) {
      const EdgeUse &x = uses.front(), &y = uses.back();
      edges_.push_back({x.a, x.b, {x.triangle, y.triangle}, (mesh.vertices[x.b] - mesh.vertices[x.a]).norm()});
    });
    first_.assign(mesh.vertices.size() + 1, 0);
    for (const Edge& e : edges_) {
      ++first_[e.a + 1];
      ++first_[e.b + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    at_.resize(2 * edges_.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      const Edge& edge = edges_[e];
      at_[next[edge.a]++] = {edge.length, edge.b, e};
      at_[next[edge.b]++] = {edge.length, edge.a, e};
    }
  }

  // The shortest walks through `root` that bound nothing, up to a length.
  std::vector<ShortLoop> loopsThrough(std::uint32_t root, double longest) const {
    // No edge whose walk is as short as this has an end farther from the root than half of it.
    const double longest_walk = longest * 4;
    std::vector<double> distance(first_.size() - 1, kInfinity);
    std::vector<std::uint32_t> by(distance.size(), kNoEdge);  // edge towards the root
    using Item = std::pair<double, std::uint32_t>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
    distance[root] = 0;
    queue.push({0, root});
    while (!queue.empty()) {
      const auto [d, v] = queue.top();
      queue.pop();
      if (d > distance[v]) continue;
      if (2 * d > longest_walk) break;
      for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
        const Way& way = at_[i];
        if (!(d + way.length < distance[way.to])) continue;
        distance[way.to] = d + way.length;
        by[way.to] = way.edge;
        queue.push({distance[way.to], way.to});
      }
    }

    // Edges outside of the tree, those of the longest walks first. The order only matters among the short walks. Far
    // from the root the tree is not known: it does not part the triangles there, so that any edge joins them.
    DisjointSets sets(triangles_);
    std::vector<std::pair<double, std::uint32_t>> rest;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      const Edge& edge = edges_[e];
      const double a = distance[edge.a], b = distance[edge.b], walk_length = a + b + edge.length;
      if (2 * std::max(a, b) > longest_walk)
        sets.join(edge.triangles[0], edge.triangles[1]);
      else if (by[edge.a] == e || by[edge.b] == e || walk_length == kInfinity)
        continue;
      else if (walk_length > longest_walk)
        sets.join(edge.triangles[0], edge.triangles[1]);
      else
        rest.push_back({walk_length, e});
    }
    std::sort(rest.begin(), rest.end(), [](const auto& x, const auto& y) {
      return x.first != y.first ? x.first > y.first : x.second < y.second;
    });

    std::vector<ShortLoop> out;
    for (const auto& [length, e] : rest) {
      if (sets.join(edges_[e].triangles[0], edges_[e].triangles[1])) continue;
      ShortLoop loop = walk(e, by);
      if (loop.length <= longest && loop.vertices.size() >= 3) out.push_back(std::move(loop));
    }
    return out;
  }

  // A vertex of each edge that closes a walk through `root`, of any length.
  std::vector<std::uint32_t> closingVertices(std::uint32_t root) const {
    std::vector<std::uint32_t> out;
    for (const ShortLoop& loop : loopsThrough(root, kInfinity)) out.push_back(loop.vertices.front());
    return out;
  }

 private:
  // From the edge back along the tree to where both ways meet.
  ShortLoop walk(std::uint32_t closing, const std::vector<std::uint32_t>& by) const {
    const auto way = [&](std::uint32_t v) {
      std::vector<std::uint32_t> out{v};
      while (by[v] != kNoEdge) {
        const Edge& e = edges_[by[v]];
        v = e.a == v ? e.b : e.a;
        out.push_back(v);
      }
      return out;
    };
    std::vector<std::uint32_t> forth = way(edges_[closing].a), back = way(edges_[closing].b);
    while (forth.size() > 1 && back.size() > 1 && forth[forth.size() - 2] == back[back.size() - 2]) {
      forth.pop_back();
      back.pop_back();
    }

    ShortLoop loop;
    loop.length = edges_[closing].length;
    for (std::size_t i = 0; i + 1 < forth.size(); ++i) loop.length += edges_[by[forth[i]]].length;
    for (std::size_t i = 0; i + 1 < back.size(); ++i) loop.length += edges_[by[back[i]]].length;
    loop.vertices = std::move(forth);  // its last vertex is where both ways meet
    for (std::size_t i = back.size() - 1; i-- > 0;) loop.vertices.push_back(back[i]);
    return loop;
  }

  struct Way {
    double length;
    std::uint32_t to, edge;
  };

  std::size_t triangles_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> first_;
  std::vector<Way> at_;  // from vertex v: at_[first_[v] .. first_[v + 1])
};

struct RingPoint {
  Vec3d at, normal;
};

// A ring on the surface beside a loop. It crosses the edges that leave the loop's vertices on one side, and none of
// these vertices. Between two of its points it lies in one triangle.
std::vector<RingPoint> ringBeside(const Mesh& mesh, std::vector<std::uint32_t> loop, bool is_left, double aside) {
  if (!is_left) std::reverse(loop.begin(), loop.end());
  std::unordered_map<std::uint64_t, std::uint32_t> triangle_of;  // of the edge in its direction
  const auto key = [](std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; };
  std::vector<char> is_on(mesh.vertices.size(), 0);
  for (const std::uint32_t v : loop) is_on[v] = 1;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      if (is_on[a] || is_on[b]) triangle_of[key(a, b)] = t;
    }

  std::vector<RingPoint> out;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::uint32_t v = loop[i], before = loop[(i + loop.size() - 1) % loop.size()],
                        after = loop[(i + 1) % loop.size()];
    std::vector<RingPoint> here;
    for (std::uint32_t w = after; w != before;) {
      const auto at = triangle_of.find(key(v, w));
      if (at == triangle_of.end() || here.size() > 10'000) return {};
      const Triangle& f = mesh.triangles[at->second];
      const std::uint32_t x = f[0] == v ? f[2] : f[1] == v ? f[0] : f[1];
      if (x != before) {
        const Vec3d one = doubleAreaVector(mesh, at->second).normalized();
        const auto other = triangle_of.find(key(v, x));
        const Vec3d two = other == triangle_of.end() ? one : doubleAreaVector(mesh, other->second).normalized();
        Vec3d normal = one + two;
        if (normal.norm() > 1e-3) normal.normalize();
        here.push_back({mesh.vertices[v] + aside * (mesh.vertices[x] - mesh.vertices[v]), normal});
      }
      w = x;
    }
    out.insert(out.end(), here.rbegin(), here.rend());
  }
  return out;
}

}  // namespace

std::vector<ShortLoop> shortLoops(const Mesh& solid, double longest_mm, const Progress& progress) {
  constexpr std::size_t kMostRoots = 60;
  const Graph graph(solid);

  // One root in each piece, then one on each walk that was found from there.
  const Pieces pieces = edgeConnectedPieces(solid);
  std::vector<char> has_root(pieces.count, 0);
  std::vector<std::uint32_t> roots;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t)
    if (!has_root[pieces.label[t]]) {
      has_root[pieces.label[t]] = 1;
      for (const std::uint32_t v : graph.closingVertices(solid.triangles[t][0])) roots.push_back(v);
    }
  roots.resize(std::min(roots.size(), kMostRoots));

  std::vector<ShortLoop> found;
  for (const std::uint32_t root : roots) {
    if (!report(progress, 0.92, "looking for pinholes")) return {};
    for (ShortLoop& loop : graph.loopsThrough(root, longest_mm)) {
      for (const std::uint32_t v : loop.vertices) loop.middle += solid.vertices[v];
      loop.middle /= static_cast<double>(loop.vertices.size());
      found.push_back(std::move(loop));
    }
  }
  std::sort(found.begin(), found.end(), [](const ShortLoop& x, const ShortLoop& y) {
    return x.length != y.length ? x.length < y.length : x.vertices < y.vertices;
  });

  std::vector<ShortLoop> out;
  const RayWinding rays(solid);
  for (ShortLoop& loop : found) {
    const bool is_known = std::any_of(out.begin(), out.end(), [&](const ShortLoop& other) {
      return std::any_of(loop.vertices.begin(), loop.vertices.end(), [&](std::uint32_t v) {
        return std::find(other.vertices.begin(), other.vertices.end(), v) != other.vertices.end();
      });
    });
    if (is_known) continue;
    const auto winding = rays.at(loop.middle, [](std::uint32_t) { return false; });
    loop.is_tunnel = (winding ? *winding : windingNumber(solid, loop.middle)) < 0.5;
    out.push_back(std::move(loop));
  }
  return out;
}

Mesh plugOf(const Mesh& solid, const ShortLoop& loop, bool is_left) {
  constexpr double kAside = 0.3;                                    // of the edges that the ring crosses
  constexpr double kLet = 0.1, kLeastLet = 0.004, kMostLet = 0.03;  // into the solid: of the radius; mm
  constexpr double kHeight = 0.2, kLeastHeight = 0.01;              // of each cone: of the radius; mm
  const std::vector<RingPoint> ring = ringBeside(solid, loop.vertices, is_left, kAside);
  const std::size_t n = ring.size();
  if (n < 3) return {};

  Vec3d middle = Vec3d::Zero(), normal = Vec3d::Zero();
  for (const RingPoint& p : ring) middle += p.at / static_cast<double>(n);
  double radius = 0;
  for (std::size_t i = 0; i < n; ++i) {
    normal += (ring[i].at - middle).cross(ring[(i + 1) % n].at - middle);
    radius += (ring[i].at - middle).norm() / static_cast<double>(n);
  }
  if (!(normal.norm() > 0)) return {};
  normal.normalize();

  const double let = (loop.is_tunnel ? -1 : 1) * std::clamp(kLet * radius, kLeastLet, kMostLet);
  const double height = std::max(kHeight * radius, kLeastHeight);
  Mesh plug;
  for (const RingPoint& p : ring) plug.vertices.push_back(roundedToFloat(Vec3d(p.at + let * p.normal)));
  plug.vertices.push_back(roundedToFloat(Vec3d(middle + height * normal)));
  plug.vertices.push_back(roundedToFloat(Vec3d(middle - height * normal)));
  auto top = static_cast<std::uint32_t>(n), bottom = static_cast<std::uint32_t>(n + 1);
  if (!loop.is_tunnel) std::swap(top, bottom);
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto next = static_cast<std::uint32_t>((i + 1) % n);
    plug.triangles.push_back({i, next, top});
    plug.triangles.push_back({next, i, bottom});
  }
  return plug;
}

}  // namespace kerf::internal
