#include "preprocess/close/nesting.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "geometry/mesh/box_tree.h"

namespace kerf::internal {

std::vector<NestingLevel> nestingLevels(const Mesh& mesh) {
  const Pieces pieces = edgeConnectedPieces(mesh);
  std::vector<double> volume(pieces.count, 0);
  std::vector<Box3> box(pieces.count);
  const Vec3d c = bounds(mesh).center();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    volume[pieces.label[t]] += (mesh.corner(t, 0) - c).dot((mesh.corner(t, 1) - c).cross(mesh.corner(t, 2) - c)) / 6;
    for (int k = 0; k < 3; ++k) box[pieces.label[t]].add(mesh.corner(t, k));
  }

  // Depth by boxes: a void's depth is one more than the smallest solid box around it, and so on. Boxes are a safe order
  // here: pieces do not cross, and a level is applied as a whole, so siblings do not matter.
  std::vector<std::uint32_t> order(pieces.count);
  for (std::uint32_t p = 0; p < pieces.count; ++p) order[p] = p;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double va = std::abs(volume[a]), vb = std::abs(volume[b]);
    return va != vb ? va > vb : a < b;
  });

  std::vector<std::size_t> rank(pieces.count);
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = i;

  const BoxTree boxes(std::move(box));
  std::vector<int> depth(pieces.count, 0);
  for (const std::uint32_t p : order) {
    const bool is_void = volume[p] < 0;
    const Box3& inner = boxes.boxes()[p];
    int deepest_around = is_void ? 0 : -1;
    boxes.visit([&](const Box3& node) { return holds(node, inner); },
                [&](std::uint32_t q) {
                  if (rank[q] < rank[p] && (volume[q] < 0) != is_void && holds(boxes.boxes()[q], inner) &&
                      (is_void || depth[q] > 0))
                    deepest_around = std::max(deepest_around, depth[q]);
                  return true;
                });
    depth[p] = is_void ? (deepest_around % 2 == 0 ? deepest_around + 1 : deepest_around)
                       : (deepest_around < 0 ? 0 : deepest_around + 1);
  }

  std::map<int, NestingLevel> levels;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) levels[depth[pieces.label[t]]].triangles.push_back(t);
  std::vector<NestingLevel> out;
  for (auto& [d, level] : levels) {
    level.is_void = d % 2 == 1;
    out.push_back(std::move(level));
  }
  return out;
}

}  // namespace kerf::internal
