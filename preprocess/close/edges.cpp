#include "preprocess/close/edges.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace kerf::internal {
namespace {

constexpr std::uint32_t kNone = ~0u;

}  // namespace

std::vector<EdgeUse> edgeUses(const std::vector<Triangle>& triangles) {
  // Buckets by a.
  std::uint32_t vertices = 0;
  for (const Triangle& f : triangles) vertices = std::max({vertices, f[0] + 1, f[1] + 1, f[2] + 1});
  std::vector<std::uint32_t> begin(vertices + 1, 0);
  for (const Triangle& f : triangles)
    for (std::size_t k = 0; k < 3; ++k) ++begin[std::min(f[k], f[(k + 1) % 3]) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());

  std::vector<EdgeUse> uses(3 * triangles.size());
  std::vector<std::uint32_t> at(begin.begin(), begin.end());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t p = triangles[t][k], q = triangles[t][(k + 1) % 3], a = std::min(p, q);
      uses[at[a]++] = {a, std::max(p, q), t, p < q};
    }
  for (std::uint32_t v = 0; v < vertices; ++v)
    std::sort(uses.begin() + begin[v], uses.begin() + begin[v + 1],
              [](const EdgeUse& x, const EdgeUse& y) { return x.b != y.b ? x.b < y.b : x.triangle < y.triangle; });
  return uses;
}

std::vector<EdgeCount> countEdges(const std::vector<Triangle>& triangles) {
  std::vector<EdgeCount> edges;
  edges.reserve(triangles.size() * 3 / 2);
  forEachEdge(edgeUses(triangles), [&](std::span<const EdgeUse> uses) {
    EdgeCount e{uses[0].a, uses[0].b, 0, 0};
    for (const EdgeUse& u : uses) ++(u.forth ? e.forth : e.back);
    edges.push_back(e);
  });
  return edges;
}

bool sortCorners(Triangle& f) {
  bool even = true;
  const auto order = [&](std::size_t i, std::size_t j) {
    if (f[i] <= f[j]) return;
    std::swap(f[i], f[j]);
    even = !even;
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  return even;
}

std::vector<Loop> boundaryLoops(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> missing;  // from, to
  for (const EdgeCount& e : countEdges(triangles)) {
    for (int k = e.back; k < e.forth; ++k) missing.push_back({e.b, e.a});
    for (int k = e.forth; k < e.back; ++k) missing.push_back({e.a, e.b});
  }
  std::sort(missing.begin(), missing.end());

  // Takes the first unused edge that leaves a vertex: the search begins at `next`.
  std::vector<char> used(missing.size(), 0);
  std::map<std::uint32_t, std::size_t> next;
  for (std::size_t i = missing.size(); i-- > 0;) next[missing[i].first] = i;
  const auto take = [&](std::uint32_t from) {
    const auto it = next.find(from);
    if (it == next.end()) return kNone;
    for (std::size_t& i = it->second; i < missing.size() && missing[i].first == from; ++i)
      if (!used[i]) {
        used[i] = 1;
        return missing[i].second;
      }
    return kNone;
  };

  // Every vertex has as many missing edges in as out, so a walk only ends where it met itself: that part is a loop.
  std::vector<Loop> loops;
  for (std::size_t seed = 0; seed < missing.size(); ++seed) {
    if (used[seed]) continue;
    Loop path{missing[seed].first};
    std::map<std::uint32_t, std::size_t> place{{path[0], 0}};
    for (std::uint32_t v = take(path.back()); v != kNone; v = take(path.back())) {
      const auto met = place.find(v);
      if (met == place.end()) {
        place[v] = path.size();
        path.push_back(v);
        continue;
      }
      const std::size_t start = met->second;
      loops.emplace_back(path.begin() + static_cast<std::ptrdiff_t>(start), path.end());
      for (std::size_t i = start + 1; i < path.size(); ++i) place.erase(path[i]);
      path.resize(start + 1);
    }
  }
  return loops;
}

bool isClosedManifold(const Mesh& mesh) {
  for (const EdgeCount& e : countEdges(mesh.triangles))
    if (e.forth != 1 || e.back != 1) return false;

  // One fan per vertex: its corners, by the edge they begin with ...
  struct Corner {
    std::uint32_t v, from, to;
  };
  std::vector<std::uint32_t> begin(mesh.vertices.size() + 1, 0);
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f) ++begin[v + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Corner> corners(3 * mesh.triangles.size());
  std::vector<std::uint32_t> place(begin.begin(), begin.end());
  for (const Triangle& f : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) corners[place[f[k]]++] = {f[k], f[(k + 1) % 3], f[(k + 2) % 3]};
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    std::sort(corners.begin() + begin[v], corners.begin() + begin[v + 1],
              [](const Corner& x, const Corner& y) { return x.from < y.from; });

  // ... walked around and counted.
  for (std::size_t i = 0, j = 0; i < corners.size(); i = j) {
    while (j < corners.size() && corners[j].v == corners[i].v) ++j;
    std::size_t steps = 0;
    std::uint32_t at = corners[i].from;
    do {
      const auto it = std::lower_bound(corners.begin() + static_cast<std::ptrdiff_t>(i),
                                       corners.begin() + static_cast<std::ptrdiff_t>(j), at,
                                       [](const Corner& c, std::uint32_t w) { return c.from < w; });
      at = it->to;
      ++steps;
    } while (at != corners[i].from && steps <= j - i);
    if (steps != j - i) return false;
  }
  return true;
}

}  // namespace kerf::internal
