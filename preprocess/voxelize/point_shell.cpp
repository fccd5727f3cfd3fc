#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointConversion.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "geometry/field/brick_field.h"
#include "preprocess/voxelize/point_shell.h"
#include "preprocess/voxelize/smooth_delta.h"

namespace kerf::internal {
namespace {

using openvdb::FloatGrid;
using openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;
namespace pts = openvdb::points;
using ShellLeaf = pts::PointDataTree::LeafNodeType;
using PositionCodec = pts::FixedPointCodec<false, pts::PositionRange>;

/// One leaf of the shell (null when the surface is not near) and its contribution to the sums.
struct LeafShell {
  std::unique_ptr<ShellLeaf> leaf;
  std::uint64_t points = 0;
  double area = 0, inside_nodes = 0;
};

/// The labels of one leaf, stored or constant.
struct LeafMaterial {
  const openvdb::Int32Tree::LeafNodeType* leaf = nullptr;
  std::int32_t constant = 0;
};

/// The points of one leaf, in the order of its nodes.
struct LeafPoints {
  std::vector<openvdb::Vec3f> normals;
  std::vector<float> areas;
  std::vector<std::int32_t> labels;            // empty if the material is constant
  std::vector<ShellLeaf::ValueType> offsets =  // per node: how many points up to it
      std::vector<ShellLeaf::ValueType>(kBrickNodes);
};

LeafPoints pointsOfLeaf(const FloatLeaf& leaf, const FloatGrid::ConstUnsafeAccessor& accessor, double h,
                        const LeafMaterial& material, LeafShell& sums) {
  const double e = kShellVoxels * h;
  const float* v = leaf.buffer().data();
  LeafPoints out;
  for (int n = 0; n < kBrickNodes; ++n) {
    const double value = v[n];
    sums.inside_nodes += insideFraction(value, h);
    if (std::abs(value) < e) {
      constexpr std::array<int, 3> kStep{64, 8, 1};
      const openvdb::Coord c = leaf.offsetToGlobalCoord(static_cast<openvdb::Index>(n));
      openvdb::Vec3d gradient;
      for (int axis = 0; axis < 3; ++axis) {
        const int step = kStep[static_cast<std::size_t>(axis)], local = n / step % kBrickSide;
        openvdb::Coord up = c, down = c;
        ++up[axis];
        --down[axis];
        const double high = local < kBrickSide - 1 ? v[n + step] : accessor.getValue(up);
        const double low = local > 0 ? v[n - step] : accessor.getValue(down);
        gradient[axis] = (high - low) / (2 * h);
      }

      const double length = gradient.length(), area = smoothDelta(value, e) * length * h * h * h;
      if (area > 0) {
        out.normals.emplace_back(-gradient / length);
        out.areas.push_back(static_cast<float>(area));
        if (material.leaf) out.labels.push_back(material.leaf->getValue(static_cast<openvdb::Index>(n)));
        sums.area += area;
      }
    }
    out.offsets[static_cast<std::size_t>(n)] = static_cast<ShellLeaf::ValueType>(out.areas.size());
  }
  return out;
}

// A material that is the same all over the leaf costs no memory.
std::unique_ptr<ShellLeaf> leafOf(const openvdb::Coord& origin, const LeafPoints& points,
                                  std::int32_t constant_material, const pts::AttributeSet::DescriptorPtr& descriptor,
                                  const pts::AttributeArray::ScopedRegistryLock& lock) {
  const std::vector<std::int32_t>& labels = points.labels;
  const auto count = static_cast<openvdb::Index>(points.areas.size());
  auto leaf = std::make_unique<ShellLeaf>(origin);
  auto set = std::make_unique<pts::AttributeSet>(descriptor, count, &lock);
  pts::AttributeWriteHandle<openvdb::Vec3f, PositionCodec>(*set->get("P")).collapse(openvdb::Vec3f(0));

  pts::AttributeWriteHandle<std::int32_t> label(*set->get("material"));
  if (std::adjacent_find(labels.begin(), labels.end(), std::not_equal_to<>()) == labels.end())
    label.collapse(labels.empty() ? constant_material : labels.front());
  else
    for (openvdb::Index i = 0; i < count; ++i) label.set(i, labels[i]);

  pts::AttributeWriteHandle<openvdb::Vec3f, pts::UnitVecCodec> normal(*set->get("N"));
  pts::AttributeWriteHandle<float> area(*set->get("area"));
  for (openvdb::Index i = 0; i < count; ++i) {
    normal.set(i, points.normals[i]);
    area.set(i, points.areas[i]);
  }
  leaf->replaceAttributeSet(set.release(), true);
  leaf->setOffsets(points.offsets);
  return leaf;
}

LeafShell shellOfLeaf(const FloatLeaf& leaf, const FloatGrid::ConstUnsafeAccessor& accessor,
                      const pts::AttributeSet::DescriptorPtr& descriptor,
                      const pts::AttributeArray::ScopedRegistryLock& lock, double h, const LeafMaterial& material) {
  LeafShell out;
  const LeafPoints points = pointsOfLeaf(leaf, accessor, h, material, out);
  out.points = points.areas.size();
  if (out.points > 0) out.leaf = leafOf(leaf.origin(), points, material.constant, descriptor, lock);
  return out;
}

// Nodes of the uniform places inside, in the bricks that matter.
double insideNodesOfTiles(const FloatTree& tree, const std::function<bool(const openvdb::Coord&)>& keep) {
  double inside = 0;
  auto tile = tree.cbeginValueOff();
  tile.setMaxDepth(FloatTree::ValueOffCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (tile.getValue() >= 0) continue;
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    for (int x = box.min().x(); x <= box.max().x(); x += kBrickSide)
      for (int y = box.min().y(); y <= box.max().y(); y += kBrickSide)
        for (int z = box.min().z(); z <= box.max().z(); z += kBrickSide)
          if (keep({x, y, z})) inside += kBrickNodes;
  }
  return inside;
}

}  // namespace

PointShell makePointShell(const FloatGrid& phi, const openvdb::Int32Grid& material,
                          const std::function<bool(const openvdb::Coord&)>& keep, Interrupter& interrupter) {
  const double h = phi.voxelSize()[0];
  std::vector<const FloatLeaf*> leaves;
  leaves.reserve(phi.tree().leafCount());
  phi.tree().getNodes(leaves);
  std::erase_if(leaves, [&](const FloatLeaf* leaf) { return !keep(leaf->origin()); });

  const auto descriptor =
      pts::AttributeSet::Descriptor::create(pts::TypedAttributeArray<openvdb::Vec3f, PositionCodec>::attributeType())
          ->duplicateAppend("N", pts::TypedAttributeArray<openvdb::Vec3f, pts::UnitVecCodec>::attributeType())
          ->duplicateAppend("area", pts::TypedAttributeArray<float>::attributeType())
          ->duplicateAppend("material", pts::TypedAttributeArray<std::int32_t>::attributeType());

  const pts::AttributeArray::ScopedRegistryLock lock;
  std::vector<LeafShell> made(leaves.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 32),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      if (interrupter.wasInterrupted()) return;
                      const FloatGrid::ConstUnsafeAccessor accessor(phi.tree());
                      for (std::size_t l = range.begin(); l != range.end(); ++l) {
                        const openvdb::Coord origin = leaves[l]->origin();
                        LeafMaterial labels{material.tree().probeConstLeaf(origin), 0};
                        if (!labels.leaf) labels.constant = material.tree().getValue(origin);
                        made[l] = shellOfLeaf(*leaves[l], accessor, descriptor, lock, h, labels);
                      }
                    });

  PointShell out;
  const auto grid = pts::PointDataGrid::create();
  grid->setName("shell");
  grid->setTransform(phi.transform().copy());
  double inside = 0;
  for (LeafShell& leaf : made) {  // in the tree's own order: the sums do not depend on threads
    out.points += leaf.points;
    out.area_mm2 += leaf.area;
    inside += leaf.inside_nodes;
    if (leaf.leaf) grid->tree().addLeaf(leaf.leaf.release());
  }
  inside += insideNodesOfTiles(phi.tree(), keep);
  out.volume_mm3 = inside * h * h * h;
  out.grid = grid;
  return out;
}

}  // namespace kerf::internal
