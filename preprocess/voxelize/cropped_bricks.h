// Copy of a grid with only some bricks set.
#pragma once

#include <openvdb/openvdb.h>

#include <algorithm>

#include "geometry/field/brick_field.h"

namespace kerf::internal {

/// A grid with the bricks (8^3 nodes, by their first node) for which keep() is true: leaves unchanged, and larger
/// uniform regions brick by brick, as tiles. Name, class, transform and metadata stay.
template <class Grid, class Keep>
typename Grid::Ptr croppedBricks(const Grid& grid, const Keep& keep) {
  using Tree = typename Grid::TreeType;
  auto out = grid.copyWithNewTree();
  Tree& tree = out->tree();
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    if (keep(leaf->origin())) tree.addLeaf(new typename Tree::LeafNodeType(*leaf));
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    const auto value = tile.getValue();
    if (value == grid.background() && !tile.isValueOn()) continue;
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    for (int x = box.min().x(); x <= box.max().x(); x += kBrickSide)
      for (int y = box.min().y(); y <= box.max().y(); y += kBrickSide)
        for (int z = box.min().z(); z <= box.max().z(); z += kBrickSide)
          if (const openvdb::Coord origin(x, y, z); keep(origin)) tree.addTile(1, origin, value, tile.isValueOn());
  }
  return out;
}

}  // namespace kerf::internal
