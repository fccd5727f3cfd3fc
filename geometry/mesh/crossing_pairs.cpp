#include "geometry/mesh/crossing_pairs.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "geometry/mesh/box_tree.h"

namespace kerf {
namespace {

using CrossingKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CrossingPoint = CrossingKernel::Point_3;

CrossingPoint point(const Vec3d& p) { return {p.x(), p.y(), p.z()}; }

/// The two ends of a triangle without area, as places in the triangle.
std::array<int, 2> farEnds(const Mesh& mesh, std::uint32_t t) {
  std::array<int, 2> best{0, 1};
  double longest = -1;
  for (int k = 0; k < 3; ++k) {
    const double d = (mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3)).squaredNorm();
    if (d > longest) {
      longest = d;
      best = {k, (k + 1) % 3};
    }
  }
  return best;
}

/// A triangle without area against a proper one: do they meet away from shared vertices?
bool flatMeets(const Mesh& mesh, std::uint32_t flat, std::uint32_t other) {
  const Triangle& f = mesh.triangles[flat];
  const Triangle& g = mesh.triangles[other];
  const auto shared = [&](std::uint32_t v) { return v == g[0] || v == g[1] || v == g[2]; };
  const CrossingKernel::Triangle_3 proper(point(mesh.vertices[g[0]]), point(mesh.vertices[g[1]]),
                                          point(mesh.vertices[g[2]]));
  for (const std::uint32_t v : f)
    if (!shared(v) && proper.has_on(point(mesh.vertices[v]))) return true;
  const auto ends = farEnds(mesh, flat);
  const std::uint32_t a = f[static_cast<std::size_t>(ends[0])], b = f[static_cast<std::size_t>(ends[1])];
  if (mesh.vertices[a] == mesh.vertices[b] || shared(a) || shared(b)) return false;
  return CGAL::do_intersect(CrossingKernel::Segment_3(point(mesh.vertices[a]), point(mesh.vertices[b])), proper);
}

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

/// Adds the pairs of triangles without area: with themselves and with each proper triangle they meet.
/// @param is_wanted  asked for each pair.
template <class IsWanted>
void addFlatPairs(const Mesh& mesh, const IsWanted& is_wanted, std::size_t stop_after, Pairs& pairs) {
  const std::vector<std::uint32_t> flat = degenerateTriangles(mesh.vertices, mesh.triangles);
  if (flat.empty()) return;
  std::vector<char> is_flat(mesh.triangles.size(), 0);
  for (const std::uint32_t t : flat) is_flat[t] = 1;
  const auto boxOf = [&](std::uint32_t t) {
    Box3 box;
    for (int k = 0; k < 3; ++k) box.add(mesh.corner(t, k));
    return box;
  };
  std::vector<Box3> boxes;
  for (const std::uint32_t t : flat) boxes.push_back(boxOf(t));
  const BoxTree tree(std::move(boxes));

  constexpr std::size_t kGrain = 4096;
  std::vector<Pairs> met((mesh.triangles.size() + kGrain - 1) / kGrain);
  std::atomic<std::size_t> found = pairs.size();
  const auto meetFlats = [&](std::uint32_t t, Pairs& out) {
    const Box3 box = boxOf(t);
    tree.visit([&](const Box3& node) { return overlap(node, box); },
               [&](std::uint32_t n) {
                 if (is_wanted(flat[n], t) && overlap(tree.boxes()[n], box) && flatMeets(mesh, flat[n], t)) {
                   out.push_back({std::min(flat[n], t), std::max(flat[n], t)});
                   ++found;
                 }
                 return found <= stop_after;
               });
  };
  tbb::parallel_for(std::size_t{0}, met.size(), [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kGrain, mesh.triangles.size());
    for (std::size_t t = block * kGrain; t < end; ++t)
      if (!is_flat[t]) meetFlats(static_cast<std::uint32_t>(t), met[block]);
  });

  for (const std::uint32_t t : flat)
    if (is_wanted(t, t)) pairs.push_back({t, t});
  for (const Pairs& some : met) pairs.insert(pairs.end(), some.begin(), some.end());
  std::sort(pairs.begin(), pairs.end());
}

}  // namespace

std::vector<std::array<std::uint32_t, 2>> crossingPairs(const Mesh& mesh, std::size_t stop_after) {
  Pairs pairs;
  for (const auto& [i, j] : selfIntersections(mesh.vertices, mesh.triangles, stop_after)) pairs.push_back({i, j});
  addFlatPairs(
      mesh, [](std::uint32_t, std::uint32_t) { return true; }, stop_after, pairs);
  return pairs;
}

std::vector<std::array<std::uint32_t, 2>> crossingPairsOf(const Mesh& mesh, const std::vector<char>& chosen) {
  Pairs pairs;
  for (const auto& [i, j] : selfIntersectionsOf(mesh.vertices, mesh.triangles, chosen)) pairs.push_back({i, j});
  const auto isWanted = [&](std::uint32_t s, std::uint32_t t) { return chosen[s] != 0 || chosen[t] != 0; };
  addFlatPairs(mesh, isWanted, kAllPairs, pairs);
  return pairs;
}

}  // namespace kerf
