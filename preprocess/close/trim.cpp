#include "preprocess/close/trim.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <span>
#include <utility>

#include "preprocess/close/edges.h"
#include "preprocess/close/orient.h"

namespace kerf::internal {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

// The edges of a mesh, from either end.
class EdgeGraph {
 public:
  explicit EdgeGraph(const Mesh& mesh) : begin_(mesh.vertices.size() + 1, 0) {
    const std::vector<EdgeCount> edges = countEdges(mesh.triangles);
    for (const EdgeCount& e : edges) {
      ++begin_[e.a + 1];
      ++begin_[e.b + 1];
      lengths_.push_back((mesh.vertices[e.a] - mesh.vertices[e.b]).norm());
    }
    for (std::size_t v = 1; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];

    ways_.resize(2 * edges.size());
    std::vector<std::size_t> at(begin_.begin(), begin_.end() - 1);
    for (std::size_t n = 0; n < edges.size(); ++n) {
      ways_[at[edges[n].a]++] = {edges[n].b, lengths_[n]};
      ways_[at[edges[n].b]++] = {edges[n].a, lengths_[n]};
    }
  }

  struct Way {
    std::uint32_t to;
    double length;  // mm
  };
  std::span<const Way> from(std::uint32_t v) const { return {ways_.data() + begin_[v], begin_[v + 1] - begin_[v]}; }

  double medianLength() const {
    std::vector<double> sorted = lengths_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return sorted.empty() ? 0 : *middle;
  }

  // Shortest ways along edges from where the distance is finite already.
  void spread(std::vector<double>& distance) const {
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
    for (std::uint32_t v = 0; v < distance.size(); ++v)
      if (distance[v] < kFar) next.push({distance[v], v});
    while (!next.empty()) {
      const auto [d, v] = next.top();
      next.pop();
      if (d > distance[v]) continue;
      for (const Way& way : from(v)) {
        const double there = d + way.length;
        if (there >= distance[way.to]) continue;
        distance[way.to] = there;
        next.push({there, way.to});
      }
    }
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<Way> ways_;
  std::vector<double> lengths_;
};

// Distance from the core, the surface deeper than `depth` inside the rims; 0 in the core.
std::vector<double> distanceFromCore(const EdgeGraph& graph, const std::vector<double>& from_rim, double depth) {
  std::vector<double> out(from_rim.size(), kFar);
  for (std::uint32_t v = 0; v < from_rim.size(); ++v) {
    if (from_rim[v] > depth) {
      out[v] = 0;
      continue;
    }
    // The border of the core lies on the edges that lead into it.
    for (const EdgeGraph::Way& way : graph.from(v)) {
      if (!(from_rim[way.to] > depth)) continue;
      const double rise = std::min(from_rim[way.to] - from_rim[v], way.length);
      if (rise > 0) out[v] = std::min(out[v], way.length * std::min(1.0, (depth - from_rim[v]) / rise));
    }
  }
  graph.spread(out);
  return out;
}

// A disc does not reach into corners either: places that do not stick out as far as that are kept.
template <class Farthest>
void keepCorners(const Mesh& mesh, const Farthest& farthest, double least, std::vector<char>& keep) {
  std::vector<std::uint32_t> number;
  std::vector<Triangle> taken;
  for (std::uint32_t t = 0; t < keep.size(); ++t) {
    if (keep[t]) continue;
    number.push_back(t);
    taken.push_back(mesh.triangles[t]);
  }
  if (taken.empty()) return;
  const Pieces places = piecesOf(taken.size(), edgeUses(taken));
  std::vector<double> reach(places.count, 0);
  for (std::size_t n = 0; n < taken.size(); ++n)
    reach[places.label[n]] = std::max(reach[places.label[n]], farthest(number[n]));
  for (std::size_t n = 0; n < taken.size(); ++n)
    if (reach[places.label[n]] <= least) keep[number[n]] = 1;
}

// Keeps only the largest kept part of each original piece of the mesh.
void keepLargestParts(const Mesh& mesh, std::vector<char>& keep) {
  const Pieces before = edgeConnectedPieces(mesh);
  std::vector<std::uint32_t> kept;
  Mesh rest;
  rest.vertices = mesh.vertices;
  for (std::uint32_t t = 0; t < keep.size(); ++t) {
    if (!keep[t]) continue;
    kept.push_back(t);
    rest.triangles.push_back(mesh.triangles[t]);
  }

  const Pieces after = edgeConnectedPieces(rest);
  std::vector<double> area(after.count, 0);
  for (std::size_t n = 0; n < kept.size(); ++n) area[after.label[n]] += doubleAreaVector(rest, n).norm();
  std::vector<std::uint32_t> largest(before.count, kAdded);
  for (std::size_t n = 0; n < kept.size(); ++n) {
    std::uint32_t& best = largest[before.label[kept[n]]];
    if (best == kAdded || area[after.label[n]] > area[best]) best = after.label[n];
  }
  for (std::size_t n = 0; n < kept.size(); ++n)
    if (after.label[n] != largest[before.label[kept[n]]]) keep[kept[n]] = 0;
}

std::size_t countUsed(const Mesh& mesh) {
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f) used[v] = 1;
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), 1));
}

}  // namespace

Trimmed trimRims(Chain& chain, const std::vector<Loop>& rims, double width_mm) {
  const Mesh& mesh = chain.mesh;
  const EdgeGraph graph(mesh);
  const double depth = width_mm / 2, slack = std::max(depth / 4, graph.medianLength());

  // Eroded by the depth, and grown back.
  std::vector<double> from_rim(mesh.vertices.size(), kFar);
  for (const Loop& rim : rims)
    for (const std::uint32_t v : rim) from_rim[v] = 0;
  graph.spread(from_rim);
  const std::vector<double> from_core = distanceFromCore(graph, from_rim, depth);
  const auto farthest = [&](std::size_t t) {
    const Triangle& f = mesh.triangles[t];
    return std::max({from_core[f[0]], from_core[f[1]], from_core[f[2]]});
  };

  std::vector<char> keep(mesh.triangles.size(), 1);
  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = farthest(t) <= depth + slack;
  keepCorners(mesh, farthest, 2 * depth + slack, keep);
  // A piece that is narrow all over has no core: it is not the rim's, and stays.
  const Pieces pieces = edgeConnectedPieces(mesh);
  std::vector<char> has_core(pieces.count, 0);
  for (std::size_t t = 0; t < keep.size(); ++t) has_core[pieces.label[t]] |= keep[t];
  for (std::size_t t = 0; t < keep.size(); ++t)
    if (!has_core[pieces.label[t]]) keep[t] = 1;
  keepLargestParts(mesh, keep);

  Trimmed out;
  std::vector<Triangle> taken;
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (keep[t]) continue;
    taken.push_back(mesh.triangles[t]);
    out.area_mm2 += 0.5 * doubleAreaVector(mesh, t).norm();
  }
  if (taken.empty()) return out;
  out.triangles = taken.size();
  out.places = piecesOf(taken.size(), edgeUses(taken)).count;
  const std::size_t before = countUsed(mesh);
  keepOnly(chain, keep);
  out.vertices = before - countUsed(chain.mesh);
  return out;
}

}  // namespace kerf::internal
