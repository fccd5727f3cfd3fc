#include "preprocess/voxelize/paint_materials.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "preprocess/voxelize/mesh_field.h"
#include "preprocess/voxelize/smooth_delta.h"

namespace kerf::internal {
namespace {

using openvdb::BoolTree;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Index;
using openvdb::Int32Tree;
using Leaf = Int32Tree::LeafNodeType;

// While painting, a label is the claim's place in the list plus one; 0 is no claim's.
using Label = std::int32_t;

// Spread of a label into places without a claim, in voxels: gaps between parts, and the outer half of the point shell.
// Places farther from every claim count as forgotten, not as a gap.
constexpr int kFillNodes = 8;

Vec3d position(const Coord& c, double h) { return h * Vec3d(c.x(), c.y(), c.z()); }

template <class Do>
void forEachLeaf(Int32Tree& tree, Interrupter& interrupter, const Do& work) {
  openvdb::tree::LeafManager<Int32Tree> leaves(tree);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.leafCount(), 16), [&](const auto& range) {
    if (interrupter.wasInterrupted()) return;
    for (std::size_t l = range.begin(); l != range.end(); ++l) work(leaves.leaf(l), l);
  });
}

// Where the claim holds: active voxels and tiles, all with its label.
Int32Tree::Ptr coverOf(const MaterialClaim& claim, Label label, const Mesh& solid, double h, const BoolTree& domain,
                       Interrupter& interrupter) {
  if (claim.solid) {
    const FloatGrid::Ptr psi = meshField(*claim.solid, h, {1, 1}, interrupter);
    if (!psi) return nullptr;
    return std::make_shared<Int32Tree>(openvdb::tools::sdfInteriorMask(*psi)->tree(), 0, label,
                                       openvdb::TopologyCopy());
  }

  // A layer under the surface: everything that is not deeper.
  const DepthRule& rule = *claim.depth;
  const FloatGrid::Ptr psi =
      meshField(solid, h, {1, static_cast<float>(std::ceil(rule.depth_mm / h)) + 1}, interrupter);
  if (!psi) return nullptr;
  const auto deeper = openvdb::tools::sdfInteriorMask(*psi, static_cast<float>(-rule.depth_mm));
  auto cover = std::make_shared<Int32Tree>(domain, 0, label, openvdb::TopologyCopy());
  cover->topologyDifference(deeper->tree());

  if (rule.above) {
    cover->voxelizeActiveTiles();
    forEachLeaf(*cover, interrupter, [&](Leaf& leaf, std::size_t) {
      for (auto node = leaf.beginValueOn(); node; ++node)
        if (rule.above->height(position(node.getCoord(), h)) < 0) node.setValueOff();
    });
  }
  return cover;
}

// Restricts a cover to the labels that the claim may replace.
void restrictTo(Int32Tree& cover, const Int32Tree& labels, std::span<const MaterialClaim> claims,
                std::span<const Material> replaceable, Interrupter& interrupter) {
  cover.voxelizeActiveTiles();
  forEachLeaf(cover, interrupter, [&](Leaf& leaf, std::size_t) {
    const openvdb::tree::ValueAccessor<const Int32Tree, false> accessor(labels);
    for (auto node = leaf.beginValueOn(); node; ++node) {
      const Label there = accessor.getValue(node.getCoord());
      const bool may =
          there > 0 && std::find(replaceable.begin(), replaceable.end(),
                                 claims[static_cast<std::size_t>(there) - 1].material) != replaceable.end();
      if (!may) node.setValueOff();
    }
  });
}

// The most frequent label around a node, faces before edges before corners, then the earlier claim; 0 if none.
Label mostFrequentNear(const openvdb::tree::ValueAccessor<const Int32Tree, false>& labels, const Coord& node) {
  Label best = 0;
  for (int distance = 1; distance <= 3 && best == 0; ++distance) {  // faces, edges, corners
    std::array<Label, 26> near{};
    std::size_t found = 0;
    for (int n = 0; n < 27; ++n) {
      const int dx = n / 9 - 1, dy = n / 3 % 3 - 1, dz = n % 3 - 1;
      if (std::abs(dx) + std::abs(dy) + std::abs(dz) != distance) continue;
      if (const Label label = labels.getValue(node.offsetBy(dx, dy, dz)); label > 0) near[found++] = label;
    }

    std::ptrdiff_t most = 0;
    for (std::size_t n = 0; n < found; ++n)
      if (const auto votes = std::count(near.begin(), near.end(), near[n]);
          votes > most || (votes == most && near[n] < best)) {
        most = votes;
        best = near[n];
      }
  }
  return best;
}

// One more layer of voxels around labels, into nodes without one. Returns how many nodes are still without.
std::size_t grow(Int32Tree& labels, Interrupter& interrupter) {
  struct Change {
    Index node;
    Label label;
  };
  const std::size_t count = labels.leafCount();
  std::vector<std::vector<Change>> changes(count);
  std::vector<std::size_t> missing(count, 0);
  forEachLeaf(labels, interrupter, [&](Leaf& leaf, std::size_t l) {
    const openvdb::tree::ValueAccessor<const Int32Tree, false> accessor(labels);
    for (auto node = leaf.cbeginValueOn(); node; ++node) {
      if (*node != 0) continue;
      if (const Label best = mostFrequentNear(accessor, node.getCoord()); best > 0)
        changes[l].push_back({node.pos(), best});
      else
        ++missing[l];
    }
  });

  forEachLeaf(labels, interrupter, [&](Leaf& leaf, std::size_t l) {
    for (const Change& change : changes[l]) leaf.setValueOnly(change.node, change.label);
  });
  std::size_t total = 0;
  for (const std::size_t n : missing) total += n;
  return total;
}

// Volume per label, unclaimed at index 0. `inside_only` omits the outer half of the shell, which lies in no claim.
std::vector<double> volumesOf(const Int32Tree& labels, const FloatGrid& phi, std::size_t claims, bool inside_only) {
  const double h = phi.voxelSize()[0];
  std::vector<const Leaf*> leaves;
  labels.getNodes(leaves);
  std::vector<std::vector<double>> sums(leaves.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 64), [&](const auto& range) {
    for (std::size_t l = range.begin(); l != range.end(); ++l) {
      sums[l].assign(claims + 1, 0);
      const auto* field = phi.tree().probeConstLeaf(leaves[l]->origin());
      for (auto node = leaves[l]->cbeginValueOn(); node; ++node) {
        const double value = field ? static_cast<double>(field->getValue(node.pos())) : -h;
        if (!inside_only || value < 0) sums[l][static_cast<std::size_t>(*node)] += insideFraction(value, h);
      }
    }
  });

  std::vector<double> nodes(claims + 1, 0);
  for (const auto& leaf : sums)
    for (std::size_t n = 0; n < nodes.size(); ++n) nodes[n] += leaf[n];
  auto tile = labels.cbeginValueOn();
  tile.setMaxDepth(Int32Tree::ValueOnCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) nodes[static_cast<std::size_t>(*tile)] += static_cast<double>(tile.getVoxelCount());
  for (double& n : nodes) n *= h * h * h;
  return nodes;
}

// Paints from the last claim to the first, each over the previous ones. False when cancelled.
bool paintClaims(const Mesh& solid, double h, std::span<const MaterialClaim> claims, const BoolTree& domain,
                 Int32Tree& labels, Interrupter& interrupter) {
  for (std::size_t n = claims.size(); n-- > 0;) {
    const MaterialClaim& claim = claims[n];
    const auto label = static_cast<Label>(n + 1);
    if (!interrupter.step(0.7 + 0.2 * static_cast<double>(claims.size() - n) / static_cast<double>(claims.size()),
                          "materials"))
      return false;
    if (claim.covers) {
      labels.voxelizeActiveTiles();
      forEachLeaf(labels, interrupter, [&](Leaf& leaf, std::size_t) {
        for (auto node = leaf.beginValueOn(); node; ++node)
          if (claim.covers(position(node.getCoord(), h))) node.setValue(label);
      });
      continue;
    }
    const Int32Tree::Ptr cover = coverOf(claim, label, solid, h, domain, interrupter);
    if (!cover) return false;
    if (!claim.replaces.empty()) restrictTo(*cover, labels, claims, claim.replaces, interrupter);
    openvdb::tools::compReplace(labels, *cover);
  }
  return true;
}

}  // namespace

openvdb::Int32Grid::Ptr paintMaterials(const Mesh& solid, const FloatGrid& phi, const VoxelizeOptions& options,
                                       std::span<const MaterialClaim> claims, MaterialVolumes& volumes,
                                       Interrupter& interrupter) {
  const double h = phi.voxelSize()[0];
  const auto domain = openvdb::tools::sdfInteriorMask(phi, static_cast<float>(kShellVoxels * h));
  const auto gridOf = [&](const Int32Tree::Ptr& tree) {
    auto grid = openvdb::Int32Grid::create(static_cast<int>(Material::kNone));
    grid->setTree(tree);
    grid->setName("material");
    grid->setTransform(phi.transform().copy());
    if (!options.material_names.empty()) grid->insertMeta("labels", openvdb::StringMetadata(options.material_names));
    return grid;
  };

  volumes.claimed_mm3.assign(claims.size(), 0);
  if (claims.empty())
    return gridOf(std::make_shared<Int32Tree>(domain->tree(), static_cast<int>(Material::kNone),
                                              static_cast<int>(options.material), openvdb::TopologyCopy()));

  auto labels = std::make_shared<Int32Tree>(domain->tree(), 0, 0, openvdb::TopologyCopy());
  if (!paintClaims(solid, h, claims, domain->tree(), *labels, interrupter)) return nullptr;
  labels->topologyIntersection(domain->tree());

  labels->voxelizeActiveTiles();  // gaps may reach into uniform regions; merged again below
  volumes.unclaimed_mm3 = volumesOf(*labels, phi, claims.size(), true)[0];
  for (int n = 0; n < kFillNodes; ++n) {
    if (interrupter.wasInterrupted()) return nullptr;
    if (grow(*labels, interrupter) == 0) break;
  }

  const std::vector<double> sums = volumesOf(*labels, phi, claims.size(), false);
  std::copy(sums.begin() + 1, sums.end(), volumes.claimed_mm3.begin());
  volumes.forgotten_mm3 = sums[0];
  if (interrupter.isCancelled()) return nullptr;

  forEachLeaf(*labels, interrupter, [&](Leaf& leaf, std::size_t) {
    for (auto node = leaf.beginValueOn(); node; ++node)
      node.setValue(
          static_cast<int>(*node > 0 ? claims[static_cast<std::size_t>(*node) - 1].material : options.material));
  });
  if (interrupter.isCancelled()) return nullptr;
  openvdb::tools::prune(*labels);
  return gridOf(labels);
}

}  // namespace kerf::internal
