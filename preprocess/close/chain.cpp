#include "preprocess/close/chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <span>

#include "geometry/mesh/exact_weld.h"
#include "preprocess/close/close.h"
#include "preprocess/close/stitch.h"
#include "preprocess/close/winding.h"

namespace kerf::internal {
namespace {

constexpr std::uint32_t kNone = ~0u;

struct EdgeUse {
  std::uint32_t a, b, triangle;
  bool forth;
};

/// All edge uses sorted by (a, b, triangle): buckets by a, then small sorts.
std::vector<EdgeUse> edgeUses(const std::vector<Triangle>& triangles) {
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

template <class F>
void forEachEdge(const std::vector<EdgeUse>& uses, F&& f) {
  for (std::size_t i = 0, j = 0; i < uses.size(); i = j) {
    while (j < uses.size() && uses[j].a == uses[i].a && uses[j].b == uses[i].b) ++j;
    f(std::span(uses).subspan(i, j - i));
  }
}

void flip(Triangle& f) { std::swap(f[1], f[2]); }

void keepOnly(Chain& chain, const std::vector<char>& keep) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (!keep[t]) continue;
    chain.mesh.triangles[count] = chain.mesh.triangles[t];
    chain.source[count] = chain.source[t];
    if (chain.mesh.hasFaceColors()) chain.mesh.face_colors[count] = chain.mesh.face_colors[t];
    ++count;
  }
  chain.mesh.triangles.resize(count);
  chain.source.resize(count);
  if (chain.mesh.hasFaceColors()) chain.mesh.face_colors.resize(count);
}

void roundAndWeld(Chain& chain, CloseReport& report) {
  Mesh& mesh = chain.mesh;
  double largest = 0;
  for (Vec3d& p : mesh.vertices) {
    const Vec3d r = roundedToFloat(p);
    if (r != p) {
      ++report.vertices_rounded;
      largest = std::max(largest, (r - p).norm());
    }
    p = r;
  }
  if (report.vertices_rounded)
    report.changes.push_back(fmt::format("{} rounded to single precision (by {:.2g} mm at most)",
                                         counted(report.vertices_rounded, "vertex was", "vertices were"), largest));
  report.largest_move_mm = std::max(report.largest_move_mm, largest);
  ExactWelder welder(mesh.vertices.size());
  std::vector<std::uint32_t> index;
  index.reserve(mesh.vertices.size());
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    index.push_back(welder.add(mesh.vertices[v]));
    if (index.back() != count) continue;
    if (mesh.hasVertexColors()) mesh.vertex_colors[count] = mesh.vertex_colors[v];
    ++count;
  }
  report.vertices_welded = mesh.vertices.size() - count;
  if (report.vertices_welded)
    report.changes.push_back(counted(report.vertices_welded, "vertex was", "vertices were") +
                             " welded to another at the same place");
  mesh.vertices = std::move(welder.vertices);
  if (mesh.hasVertexColors()) mesh.vertex_colors.resize(count);
  if (report.vertices_welded)
    for (Triangle& f : mesh.triangles)
      for (std::uint32_t& v : f) v = index[v];
  chain.source_vertices = count;
}

/// Turns triangles so that neighbours across two-sided edges agree; in every patch the minority turns.
void orient(Chain& chain, CloseReport& report) {
  const std::size_t n = chain.mesh.triangles.size();
  const std::vector<EdgeUse> all = edgeUses(chain.mesh.triangles);
  const auto joins = [](std::span<const EdgeUse> uses) {
    return uses.size() == 2 && uses[0].triangle != uses[1].triangle;
  };
  bool any = false;
  forEachEdge(all,
              [&](std::span<const EdgeUse> uses) { any = any || (joins(uses) && uses[0].forth == uses[1].forth); });
  if (!any) return;
  std::vector<std::array<std::uint32_t, 3>> next(n, {kNone, kNone, kNone});
  std::vector<std::array<char, 3>> differs(n, {0, 0, 0});
  std::vector<int> filled(n, 0);
  forEachEdge(all, [&](std::span<const EdgeUse> uses) {
    if (!joins(uses)) return;
    const char wrong = uses[0].forth == uses[1].forth;
    for (int k = 0; k < 2; ++k) {
      const std::uint32_t t = uses[static_cast<std::size_t>(k)].triangle;
      const auto slot = static_cast<std::size_t>(filled[t]++);
      next[t][slot] = uses[static_cast<std::size_t>(1 - k)].triangle;
      differs[t][slot] = wrong;
    }
  });
  std::vector<signed char> turn(n, -1);
  std::vector<std::uint32_t> patch;
  for (std::uint32_t seed = 0; seed < n; ++seed) {
    if (turn[seed] >= 0) continue;
    patch.assign(1, seed);
    turn[seed] = 0;
    for (std::size_t i = 0; i < patch.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t t = patch[i], u = next[t][k];
        if (u == kNone || turn[u] >= 0) continue;
        turn[u] = static_cast<signed char>(turn[t] ^ differs[t][k]);
        patch.push_back(u);
      }
    std::size_t turned = 0;
    for (const std::uint32_t t : patch) turned += static_cast<std::size_t>(turn[t]);
    const signed char minority = 2 * turned <= patch.size() ? 1 : 0;
    for (const std::uint32_t t : patch)
      if (turn[t] == minority) {
        flip(chain.mesh.triangles[t]);
        ++report.triangles_flipped;
      }
  }
  if (report.triangles_flipped)
    report.changes.push_back(counted(report.triangles_flipped, "triangle was", "triangles were") +
                             " turned to agree with the neighbours");
}

/// Opposite copies of a triangle cancel. Equal copies count several times in the chain, which is right where whole
/// solids coincide; where one is too many for its edges (a face stored twice in a scan) it goes.
void dropDuplicates(Chain& chain, CloseReport& report) {
  const auto& triangles = chain.mesh.triangles;
  struct Key {
    Triangle sorted;
    bool even;
    std::uint32_t t;
  };
  // Sorted by corners, then number: buckets by the smallest corner, then small sorts.
  std::uint32_t vertices = 0;
  for (const Triangle& f : triangles) vertices = std::max({vertices, f[0] + 1, f[1] + 1, f[2] + 1});
  std::vector<std::uint32_t> begin(vertices + 1, 0);
  for (const Triangle& f : triangles) ++begin[std::min({f[0], f[1], f[2]}) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Key> keys(triangles.size());
  std::vector<std::uint32_t> place(begin.begin(), begin.end());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    Triangle f = triangles[t];
    bool even = true;
    if (f[0] > f[1]) {
      std::swap(f[0], f[1]);
      even = !even;
    }
    if (f[1] > f[2]) {
      std::swap(f[1], f[2]);
      even = !even;
    }
    if (f[0] > f[1]) {
      std::swap(f[0], f[1]);
      even = !even;
    }
    keys[place[f[0]]++] = {f, even, t};
  }
  for (std::uint32_t v = 0; v < vertices; ++v)
    std::sort(keys.begin() + begin[v], keys.begin() + begin[v + 1],
              [](const Key& x, const Key& y) { return x.sorted != y.sorted ? x.sorted < y.sorted : x.t < y.t; });
  std::vector<char> keep(triangles.size(), 1);
  std::size_t cancelled = 0, merged = 0;
  std::vector<std::uint32_t> copies;  // kept members of groups of equal triangles, all but the first of each
  for (std::size_t i = 0, j = 0; i < keys.size(); i = j) {
    while (j < keys.size() && keys[j].sorted == keys[i].sorted) ++j;
    if (j - i < 2) continue;
    std::array<std::vector<std::uint32_t>, 2> sides;
    for (std::size_t k = i; k < j; ++k) sides[keys[k].even].push_back(keys[k].t);
    while (!sides[0].empty() && !sides[1].empty()) {
      for (auto& side : sides) {
        keep[side.back()] = 0;
        side.pop_back();
      }
      cancelled += 2;
    }
    for (const auto& side : sides)
      for (std::size_t k = 1; k < side.size(); ++k) copies.push_back(side[k]);
  }
  if (!copies.empty()) {
    // How many times too often each of their edges is run through, in its direction from the smaller vertex.
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> net;
    const auto edge = [&](std::uint32_t t, std::size_t k) {
      const std::uint32_t p = triangles[t][k], q = triangles[t][(k + 1) % 3];
      return std::pair(std::pair(std::min(p, q), std::max(p, q)), p < q ? 1 : -1);
    };
    for (const std::uint32_t t : copies)
      for (std::size_t k = 0; k < 3; ++k) net[edge(t, k).first] = 0;
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; keep[t] && k < 3; ++k) {
        const auto [key, sign] = edge(t, k);
        if (const auto found = net.find(key); found != net.end()) found->second += sign;
      }
    for (const std::uint32_t t : copies) {
      int excess = 0;
      for (std::size_t k = 0; k < 3; ++k) excess += net[edge(t, k).first] * edge(t, k).second > 0;
      if (excess < 2) continue;
      keep[t] = 0;
      ++merged;
      for (std::size_t k = 0; k < 3; ++k) net[edge(t, k).first] -= edge(t, k).second;
    }
  }
  if (cancelled + merged == 0) return;
  if (merged)
    report.changes.push_back(counted(merged, "duplicate triangle was", "duplicate triangles were") + " dropped");
  if (cancelled)
    report.changes.push_back(counted(cancelled, "triangle was", "triangles were") +
                             " dropped in pairs that lay back to back");
  keepOnly(chain, keep);
}

void dropRepeated(Chain& chain, CloseReport& report) {
  std::vector<char> keep;
  std::size_t dropped = 0;
  for (const Triangle& f : chain.mesh.triangles) {
    keep.push_back(f[0] != f[1] && f[1] != f[2] && f[2] != f[0]);
    dropped += !keep.back();
  }
  if (!dropped) return;
  report.changes.push_back(counted(dropped, "triangle without area was", "triangles without area were") + " dropped");
  keepOnly(chain, keep);
}

/// As edgeConnectedPieces(), from edge uses at hand.
Pieces piecesOf(std::size_t triangles, const std::vector<EdgeUse>& uses) {
  std::vector<std::uint32_t> parent(triangles);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  forEachEdge(uses, [&](std::span<const EdgeUse> edge) {
    for (std::size_t i = 1; i < edge.size(); ++i) {
      const std::uint32_t a = find(edge[0].triangle), b = find(edge[i].triangle);
      if (a != b) parent[std::max(a, b)] = std::min(a, b);
    }
  });
  Pieces pieces;
  pieces.label.resize(triangles);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::uint32_t root = find(t);
    pieces.label[t] = root == t ? pieces.count++ : pieces.label[root];
  }
  return pieces;
}

struct PieceInfo {
  Pieces pieces;
  std::vector<std::size_t> size;
  std::vector<double> area;  // mm^2
  std::vector<char> open;
};

PieceInfo lookAtPieces(const Mesh& mesh) {
  const std::vector<EdgeUse> all = edgeUses(mesh.triangles);
  PieceInfo info{piecesOf(mesh.triangles.size(), all), {}, {}, {}};
  info.size.assign(info.pieces.count, 0);
  info.area.assign(info.pieces.count, 0);
  info.open.assign(info.pieces.count, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    ++info.size[info.pieces.label[t]];
    info.area[info.pieces.label[t]] += 0.5 * doubleAreaVector(mesh, t).norm();
  }
  forEachEdge(all, [&](std::span<const EdgeUse> uses) {
    int net = 0;
    for (const EdgeUse& u : uses) net += u.forth ? 1 : -1;
    if (net != 0) info.open[info.pieces.label[uses[0].triangle]] = 1;
  });
  return info;
}

void dropCrumbs(Chain& chain, const CloseOptions& options, CloseReport& report) {
  if (!hasBoundary(chain)) return;
  const PieceInfo info = lookAtPieces(chain.mesh);
  const auto limit = options.crumb_fraction * static_cast<double>(chain.mesh.triangles.size());
  const double area_limit = 0.1 * options.crumb_fraction * std::accumulate(info.area.begin(), info.area.end(), 0.0);
  const std::size_t largest = info.pieces.count ? *std::max_element(info.size.begin(), info.size.end()) : 0;
  const auto isCrumb = [&](std::uint32_t l) {
    return info.open[l] && static_cast<double>(info.size[l]) < limit && info.area[l] < area_limit &&
           info.size[l] < largest;
  };
  std::vector<char> keep(chain.mesh.triangles.size(), 1);
  std::size_t triangles = 0;
  for (std::uint32_t t = 0; t < keep.size(); ++t)
    if (isCrumb(info.pieces.label[t])) {
      keep[t] = 0;
      ++triangles;
    }
  for (std::uint32_t l = 0; l < info.pieces.count; ++l) report.crumbs_dropped += isCrumb(l);
  if (!triangles) return;
  report.changes.push_back(fmt::format("{} dropped ({})",
                                       counted(report.crumbs_dropped, "open crumb was", "open crumbs were"),
                                       counted(triangles, "triangle", "triangles")));
  keepOnly(chain, keep);
}

}  // namespace

std::string counted(std::size_t n, const char* singular, const char* plural) {
  return fmt::format("{} {}", n, n == 1 ? singular : plural);
}

Error missingStep(std::string found, CloseStep step, const CloseOptions& options) {
  Error e;
  e.code = Error::Code::kGeometry;
  e.found = std::move(found);
  e.expected = options.only.empty() ? "a mesh that needs no such step"
                                    : fmt::format("none, as only \"{}\" is to be done", namesOf(options.only));
  std::set<CloseStep> more = options.only;
  more.insert(step);
  e.hint = "--close " + namesOf(more);
  return e;
}

std::uint32_t Chain::addVertex(const Vec3d& p) {
  mesh.vertices.push_back(p);
  if (mesh.hasVertexColors()) mesh.vertex_colors.push_back(kNeutral);
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void Chain::addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (a == b || b == c || c == a) return;
  mesh.triangles.push_back({a, b, c});
  source.push_back(kAdded);
  if (mesh.hasFaceColors()) mesh.face_colors.push_back(kNeutral);
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

std::vector<Loop> boundaryLoops(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> missing;  // from, to
  for (const EdgeCount& e : countEdges(triangles)) {
    for (int k = e.back; k < e.forth; ++k) missing.push_back({e.b, e.a});
    for (int k = e.forth; k < e.back; ++k) missing.push_back({e.a, e.b});
  }
  std::sort(missing.begin(), missing.end());
  std::vector<char> used(missing.size(), 0);
  const auto take = [&](std::uint32_t from) {
    auto it = std::lower_bound(missing.begin(), missing.end(), std::pair(from, 0u));
    for (; it != missing.end() && it->first == from; ++it) {
      const auto i = static_cast<std::size_t>(it - missing.begin());
      if (!used[i]) {
        used[i] = 1;
        return it->second;
      }
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

bool hasBoundary(const Chain& chain) {
  const std::vector<EdgeCount> edges = countEdges(chain.mesh.triangles);
  return std::any_of(edges.begin(), edges.end(), [](const EdgeCount& e) { return e.forth != e.back; });
}

bool isClosedManifold(const Mesh& mesh) {
  for (const EdgeCount& e : countEdges(mesh.triangles))
    if (e.forth != 1 || e.back != 1) return false;
  // One fan per vertex: walk around it and count.
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

bool turnPieces(Chain& chain, CloseReport& report) {
  Mesh& mesh = chain.mesh;
  const Pieces pieces = piecesOf(mesh.triangles.size(), edgeUses(mesh.triangles));
  const Vec3d center = bounds(mesh).center();
  std::vector<double> volume(pieces.count, 0), biggest_area(pieces.count, -1);
  std::vector<std::uint32_t> biggest(pieces.count, kNone);
  std::vector<Box3> box(pieces.count);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t l = pieces.label[t];
    const Vec3d a = mesh.corner(t, 0) - center, b = mesh.corner(t, 1) - center, c = mesh.corner(t, 2) - center;
    volume[l] += a.dot(b.cross(c)) / 6;
    const double area = (b - a).cross(c - a).squaredNorm();
    if (area > biggest_area[l]) {
      biggest_area[l] = area;
      biggest[l] = t;
    }
    for (int k = 0; k < 3; ++k) box[l].add(mesh.corner(t, k));
  }
  bool nested = false;
  std::vector<char> turn(pieces.count, 0);
  std::size_t turned = 0;
  // The largest first: most often it holds all others.
  std::vector<std::uint32_t> by_size(pieces.count);
  std::iota(by_size.begin(), by_size.end(), 0u);
  std::stable_sort(by_size.begin(), by_size.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return box[a].size().prod() > box[b].size().prod(); });
  std::optional<RayWinding> rays;
  for (std::uint32_t l = 0; l < pieces.count; ++l) {
    const bool inside_another = std::any_of(by_size.begin(), by_size.end(), [&](std::uint32_t o) {
      return o != l && box[o].contains(box[l].min) && box[o].contains(box[l].max);
    });
    nested = nested || inside_another;
    if (!(volume[l] < 0)) continue;
    if (inside_another) {
      const Vec3d p = (mesh.corner(biggest[l], 0) + mesh.corner(biggest[l], 1) + mesh.corner(biggest[l], 2)) / 3;
      if (!rays) rays.emplace(mesh);
      if (const auto winding = rays->at(p, [&](std::uint32_t t) { return pieces.label[t] == l; })) {
        if (*winding != 0) continue;
      } else {
        std::vector<char> skip(mesh.triangles.size());
        for (std::size_t t = 0; t < skip.size(); ++t) skip[t] = pieces.label[t] == l;
        if (std::abs(windingNumber(mesh, p, skip)) > 0.5) continue;
      }
    }
    turn[l] = 1;
    ++turned;
  }
  for (std::uint32_t t = 0; turned && t < mesh.triangles.size(); ++t)
    if (turn[pieces.label[t]]) {
      flip(mesh.triangles[t]);
      ++report.triangles_flipped;
    }
  if (turned)
    report.changes.push_back(counted(turned, "closed piece was", "closed pieces were") + " inside out and turned");
  return nested;
}

Expected<Chain> buildChain(const Mesh& imported, const CloseOptions& options, CloseReport& report) {
  // A step that is not wanted must not be needed: what it would have to do is the error.
  const auto wanted = [&](CloseStep step) { return options.only.empty() || options.only.count(step) > 0; };
  const auto needed = [&](std::string found, CloseStep step) {
    return fail(missingStep(std::move(found), step, options));
  };
  Chain chain;
  chain.mesh = imported;
  chain.source.resize(imported.triangles.size());
  std::iota(chain.source.begin(), chain.source.end(), 0u);
  roundAndWeld(chain, report);
  if (report.vertices_welded && !wanted(CloseStep::kWeld))
    return needed(counted(report.vertices_welded, "vertex at the place of another", "vertices at the place of another"),
                  CloseStep::kWeld);
  const std::size_t before = chain.mesh.triangles.size();
  dropRepeated(chain, report);
  if (const std::size_t n = before - chain.mesh.triangles.size(); n && !wanted(CloseStep::kDrop))
    return needed(counted(n, "triangle without area", "triangles without area"), CloseStep::kDrop);
  if (wanted(CloseStep::kStitch)) stitchSeams(chain, options.stitch_mm, report);
  orient(chain, report);
  if (report.triangles_flipped && !wanted(CloseStep::kOrient))
    return needed(counted(report.triangles_flipped, "triangle that disagrees with its neighbours",
                          "triangles that disagree with their neighbours"),
                  CloseStep::kOrient);
  if (wanted(CloseStep::kDrop)) {
    dropDuplicates(chain, report);
    dropCrumbs(chain, options, report);
  }
  return chain;
}

}  // namespace kerf::internal
