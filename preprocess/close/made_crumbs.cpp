#include "preprocess/close/made_crumbs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/mesh/box_tree.h"
#include "geometry/mesh/exact_weld.h"
#include "preprocess/close/chain.h"

namespace kerf::internal {
namespace {

struct Shell {
  double volume = 0;  ///< mm^3; negative: a cavity
  Box3 box{};
  std::size_t first = 0;  ///< triangle
  bool is_empty = true;
};

/// Sums volumes about a corner of each piece: about the middle of the solid a crumb would lose its digits.
std::vector<Shell> shellsOf(const Mesh& solid, const Pieces& pieces) {
  std::vector<Shell> out(pieces.count);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    Shell& shell = out[pieces.label[t]];
    if (std::exchange(shell.is_empty, false)) shell.first = t;
    const Vec3d o = solid.corner(shell.first, 0);
    shell.volume += (solid.corner(t, 0) - o).dot((solid.corner(t, 1) - o).cross(solid.corner(t, 2) - o)) / 6;
    for (int k = 0; k < 3; ++k) shell.box.add(solid.corner(t, k));
  }
  return out;
}

/// The pieces of the scan, welded as buildChain() does.
Pieces piecesOfScan(const Mesh& imported) {
  ExactWelder welder(imported.vertices.size());
  std::vector<std::uint32_t> number;
  number.reserve(imported.vertices.size());
  for (const Vec3d& p : imported.vertices) number.push_back(welder.add(weldPlace(roundedToFloat(p))));
  Mesh welded;
  welded.vertices = std::move(welder.vertices);
  welded.triangles = imported.triangles;
  for (Triangle& f : welded.triangles)
    for (std::uint32_t& v : f) v = number[v];
  return edgeConnectedPieces(welded);
}

/// Takes the mark from the pieces that hold at least half of the triangles of a piece of the scan.
void spareOwnPieces(const Mesh& imported, const Pieces& pieces, std::span<const std::uint32_t> source,
                    std::vector<char>& goes) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> held;  // piece, triangle of the scan
  for (std::size_t t = 0; t < source.size(); ++t)
    if (goes[pieces.label[t]] && source[t] != kAdded) held.push_back({pieces.label[t], source[t]});
  if (held.empty()) return;
  std::sort(held.begin(), held.end());
  held.erase(std::unique(held.begin(), held.end()), held.end());

  const Pieces scan = piecesOfScan(imported);
  std::vector<std::size_t> size(scan.count, 0);
  for (const std::uint32_t label : scan.label) ++size[label];
  for (auto& [piece, triangle] : held) triangle = scan.label[triangle];
  std::sort(held.begin(), held.end());
  for (std::size_t i = 0, j = 0; i < held.size(); i = j) {
    while (j < held.size() && held[j] == held[i]) ++j;
    if (2 * (j - i) >= size[held[i].second]) goes[held[i].first] = 0;
  }
}

/// Unmarks pieces around one that stays: without its shell that piece would lie in the wrong material.
void spareShellsAroundOthers(const std::vector<Shell>& shells, std::vector<char>& goes) {
  std::vector<Box3> boxes;
  for (const Shell& shell : shells) boxes.push_back(shell.box);
  const BoxTree tree(std::move(boxes));
  for (bool is_changed = true; std::exchange(is_changed, false);)
    for (std::size_t p = 0; p < shells.size(); ++p) {
      if (!goes[p]) continue;
      const bool is_alone =
          tree.visit([&](const Box3& box) { return overlap(box, shells[p].box); },
                     [&](std::uint32_t q) { return goes[q] || !holds(shells[p].box, shells[q].box); });
      if (is_alone) continue;
      goes[p] = 0;
      is_changed = true;
    }
}

}  // namespace

MadeCrumbs findMadeCrumbs(const Mesh& imported, const Mesh& solid, std::span<const std::uint32_t> source,
                          double most_mm3) {
  const Pieces pieces = edgeConnectedPieces(solid);
  if (pieces.count < 2) return {};
  const std::vector<Shell> shells = shellsOf(solid, pieces);
  const auto size = [](const Shell& shell) { return std::abs(shell.volume); };
  const auto largest =
      std::max_element(shells.begin(), shells.end(), [&](const Shell& a, const Shell& b) { return size(a) < size(b); });

  std::vector<char> goes(shells.size(), 0);
  for (std::size_t p = 0; p < shells.size(); ++p) goes[p] = size(shells[p]) < most_mm3;
  goes[static_cast<std::size_t>(largest - shells.begin())] = 0;
  if (std::count(goes.begin(), goes.end(), 1) == 0) return {};
  spareOwnPieces(imported, pieces, source, goes);
  spareShellsAroundOthers(shells, goes);

  MadeCrumbs out;
  for (std::size_t p = 0; p < shells.size(); ++p) {
    if (!goes[p]) continue;
    ++out.count;
    out.volume_mm3 += size(shells[p]);
  }
  if (out.count == 0) return {};
  out.keep.reserve(pieces.label.size());
  for (const std::uint32_t piece : pieces.label) out.keep.push_back(!goes[piece]);
  return out;
}

}  // namespace kerf::internal
