#include "preprocess/close/losses.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <span>

#include "preprocess/close/chain.h"
#include "preprocess/close/edges.h"
#include "preprocess/close/orient.h"
#include "preprocess/close/pinholes.h"

namespace kerf::internal {

bool lessPlace(const Vec3d& p, const Vec3d& q) {
  return p.x() != q.x() ? p.x() < q.x() : p.y() != q.y() ? p.y() < q.y() : p.z() < q.z();
}

namespace {

/// How many source vertices are lost, how many of them lie far from the rims, and where most of them are.
void countLost(const Mesh& imported, const Mesh& solid, double scale, CloseReport& report) {
  constexpr double kFar = 1, kTogether = 2;  // mm
  std::vector<Vec3d> rim = report.rim_points;
  std::sort(rim.begin(), rim.end(), lessPlace);
  const auto isFar = [&](const Vec3d& p) {
    auto at =
        std::lower_bound(rim.begin(), rim.end(), p.x() - kFar, [](const Vec3d& q, double x) { return q.x() < x; });
    for (; at != rim.end() && at->x() <= p.x() + kFar; ++at)
      if ((*at - p).norm() <= kFar) return false;
    return true;
  };

  const std::vector<Vec3d> lost = lostPlaces(imported, solid);
  report.vertices_lost = lost.size() - std::min(lost.size(), report.vertices_trimmed);
  const auto far = static_cast<std::size_t>(std::count_if(lost.begin(), lost.end(), isFar));
  report.vertices_lost_far = std::min(far, report.vertices_lost);
  // Which of them were trimmed is not known any more, and a wrap has none of them.
  if (report.exact && report.vertices_trimmed == 0) report.lost_at = heapsOf(lost, kTogether * scale);
}

/// Where to look: the finest holes first; where no hole is found, the thread of material beside one.
void reportHandles(const Mesh& solid, CloseReport& report) {
  constexpr double kLongest = 30;  // mm around
  std::vector<ShortLoop> loops = shortLoops(solid, kLongest, {});
  std::stable_partition(loops.begin(), loops.end(), [](const ShortLoop& l) { return l.is_tunnel; });
  loops.resize(std::min(loops.size(), static_cast<std::size_t>(report.handles_added)));

  std::string where;
  for (const ShortLoop& loop : loops) {
    const Vec3d& p = loop.middle;
    report.handles_at.push_back(p);
    where += fmt::format("{}({:.1f}, {:.1f}, {:.1f}), {:.2g} mm around", where.empty() ? "" : "; ", p.x(), p.y(), p.z(),
                         loop.length);
  }
  report.changes.push_back(fmt::format(
      "the solid has {} (genus) that the scan has not{}",
      counted(static_cast<std::size_t>(report.handles_added), "hole right through it", "holes right through it"),
      where.empty() ? "" : ". Look near " + where));
}

}  // namespace

std::vector<Vec3d> lostPlaces(const Mesh& imported, const Mesh& solid) {
  std::vector<Vec3d> places;
  places.reserve(solid.vertices.size());
  for (const Vec3d& p : solid.vertices) places.push_back(weldPlace(p));
  std::sort(places.begin(), places.end(), lessPlace);
  std::vector<char> used(imported.vertices.size(), 0);
  for (const Triangle& f : imported.triangles)
    for (const std::uint32_t v : f) used[v] = 1;

  std::vector<Vec3d> lost;
  for (std::size_t v = 0; v < used.size(); ++v) {
    const Vec3d p = weldPlace(roundedToFloat(imported.vertices[v]));
    if (used[v] && !std::binary_search(places.begin(), places.end(), p, lessPlace)) lost.push_back(p);
  }
  std::sort(lost.begin(), lost.end(), lessPlace);
  lost.erase(std::unique(lost.begin(), lost.end()), lost.end());
  return lost;
}

std::vector<LostPlace> heapsOf(const std::vector<Vec3d>& places, double reach_mm) {
  constexpr std::size_t kMost = 20'000;
  if (places.size() > kMost) return {};
  std::vector<std::uint32_t> parent(places.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](std::uint32_t n) {
    while (parent[n] != n) n = parent[n] = parent[parent[n]];
    return n;
  };
  for (std::uint32_t i = 0; i < places.size(); ++i)
    for (std::uint32_t j = i + 1; j < places.size() && places[j].x() - places[i].x() <= reach_mm; ++j) {
      if (!((places[j] - places[i]).norm() <= reach_mm)) continue;
      const std::uint32_t a = find(i), b = find(j);
      parent[std::max(a, b)] = std::min(a, b);
    }

  std::map<std::uint32_t, LostPlace> heaps;  // by the first place of each
  for (std::uint32_t n = 0; n < places.size(); ++n) {
    LostPlace& heap = heaps[find(n)];
    heap.middle += places[n];
    ++heap.vertices;
  }
  std::vector<LostPlace> out;
  for (auto& [first, heap] : heaps) {
    heap.middle /= static_cast<double>(heap.vertices);
    out.push_back(heap);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const LostPlace& x, const LostPlace& y) { return x.vertices > y.vertices; });
  return out;
}

int handlesOf(const Mesh& mesh) {
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f) used[v] = 1;
  const auto vertices = std::count(used.begin(), used.end(), 1);

  const std::vector<EdgeUse> all = edgeUses(mesh.triangles);
  long edges = 0;
  bool is_open = false;
  forEachEdge(all, [&](std::span<const EdgeUse> uses) {
    ++edges;
    const auto forth = std::count_if(uses.begin(), uses.end(), [](const EdgeUse& use) { return use.forth; });
    is_open = is_open || 2 * static_cast<std::size_t>(forth) != uses.size();
  });
  const auto pieces = static_cast<long>(piecesOf(mesh.triangles.size(), all).count);
  const auto boundaries = is_open ? static_cast<long>(boundaryLoops(mesh.triangles).size()) : 0;
  const long euler = static_cast<long>(vertices) - edges + static_cast<long>(mesh.triangles.size());
  return static_cast<int>(pieces - (euler + boundaries) / 2);
}

void reportLosses(const Mesh& imported, const Mesh& solid, int handles_before, double scale, CloseReport& report) {
  countLost(imported, solid, scale, report);
  if (report.rims_extruded == 0 || !report.exact) return;
  if (report.vertices_lost)
    report.changes.push_back(
        fmt::format("{} of the scan {} not in the solid, {} of them farther than 1 mm from the rim",
                    counted(report.vertices_lost, "vertex", "vertices"), report.vertices_lost == 1 ? "is" : "are",
                    report.vertices_lost_far));
  report.handles_added = handlesOf(solid) - handles_before;
  if (report.handles_added > 0) reportHandles(solid, report);
}

}  // namespace kerf::internal
