#include "geometry/field/vdb_io.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "geometry/base/large_pages.h"
#include "geometry/field/material_bricks.h"
#include "geometry/field/vdb_bricks.h"
#include "geometry/field/vdb_check.h"
#include "geometry/field/vdb_material_names.h"
#include "geometry/field/vdb_reader.h"
#include "geometry/field/vdb_writer.h"

namespace kerf {
namespace {

static_assert(openvdb::FloatTree::LeafNodeType::SIZE == kBrickNodes, "a brick is one OpenVDB leaf");

Vec3i toVec(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

// True for values outside Kerf's fields: Kerf would cut them as tissue, or use all memory.
bool isBeyond(float value, double voxel) {
  const double most = 1000 * voxel;  // mm; bands are a few voxels wide
  return !(std::abs(static_cast<double>(value)) <= most);
}

bool isFar(const openvdb::CoordBBox& box) {
  constexpr int kFarthest = 1 << (20 + kBrickLog);  // coordKey
  return openvdb::Coord::lessThan(box.min(), openvdb::Coord(-kFarthest)) ||
         openvdb::Coord::lessThan(openvdb::Coord(kFarthest - 1), box.max());
}

openvdb::FloatTree::ValueAllCIter tilesOf(const openvdb::FloatGrid& grid) {
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  return tile;
}

// Bricks deep inside that a file may state: a mandible at 0.05 mm has about one million. They take no bytes in the
// file, so a small file could state any number. A band of n leaves encloses fewer than n^1.5 bricks, and a fine region
// inside tissue has no band.
constexpr std::int64_t kMostInterior = 16'000'000, kInteriorWithoutBand = 1'000'000;

// Error in the grid, except in the values of leaves. Empty if none.
std::string faultOf(const openvdb::FloatGrid& grid) {
  const double voxel = grid.voxelSize()[0];

  const double leaves = static_cast<double>(grid.tree().leafCount());
  const std::int64_t most_interior =
      std::min(kMostInterior, kInteriorWithoutBand + static_cast<std::int64_t>(std::min(1e9, std::pow(leaves, 1.5))));
  std::int64_t interior = 0;
  for (auto tile = tilesOf(grid); tile; ++tile) {
    if (isBeyond(tile.getValue(), voxel))
      return fmt::format("a tile of {} mm {}", tile.getValue(), internal::vdbPlace(grid, tile.getCoord()));
    if (tile.getValue() >= 0) continue;
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    if (isFar(box)) return "tiles too far from the origin, " + internal::vdbPlace(grid, box.min());
    interior += static_cast<std::int64_t>(box.volume() / kBrickNodes);
    if (interior > most_interior)
      return fmt::format("more than {} bricks deep inside a band of {} bricks", most_interior, leaves);
  }

  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    if (isFar(leaf->getNodeBoundingBox()))
      return "voxels too far from the origin, " + internal::vdbPlace(grid, leaf->origin());
  return {};
}

// Error in the values of a leaf. Empty if none.
std::string faultOf(const openvdb::FloatGrid& grid, const openvdb::FloatTree::LeafNodeType& leaf,
                    const BrickValues& values) {
  const double voxel = grid.voxelSize()[0];
  // A plain loop first: the values are almost always valid.
  const auto surely_fine = static_cast<float>(500 * voxel);
  int unsure = 0;
  for (const float value : values) unsure += static_cast<int>(!(std::abs(value) <= surely_fine));
  if (unsure == 0) return {};

  const auto bad = std::find_if(values.begin(), values.end(), [voxel](float value) { return isBeyond(value, voxel); });
  if (bad == values.end()) return {};
  const openvdb::Coord at = leaf.offsetToGlobalCoord(static_cast<openvdb::Index>(bad - values.begin()));
  return fmt::format("{} mm {}", *bad, internal::vdbPlace(grid, at));
}

// A field for the bricks of a grid, which has none of them yet.
BrickField fieldFor(const openvdb::FloatGrid& grid, std::size_t bricks) {
  float interior = 0;  // the deepest constant inside; 0: no interior tiles
  for (auto tile = tilesOf(grid); tile; ++tile) interior = std::min(interior, tile.getValue());

  BrickField field(grid.voxelSize()[0], grid.background(), interior < 0 ? interior : -grid.background());
  field.reserve(bricks);
  return field;
}

// The first brick gives the address of the reserved memory; the rest is still untouched.
void adviseOnFirst(BrickField& field, std::size_t bricks) {
  if (field.brickCount() == 1) internal::adviseLargePages(&field.brick(0), bricks * sizeof(BrickValues));
}

void markTiles(const openvdb::FloatGrid& grid, BrickField& field) {
  for (auto tile = tilesOf(grid); tile; ++tile) {
    if (tile.getValue() >= 0) continue;
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    const Vec3i low = brickOf(toVec(box.min())), high = brickOf(toVec(box.max()));
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int z = low[2]; z <= high[2]; ++z) field.markInterior({x, y, z});
  }
}

// The grid's leaves from the file into the bricks of a field, one after the other.
Expected<BrickField> readBricks(internal::VdbGridFile& file, const openvdb::FloatGrid& grid,
                                const std::function<Error(const std::string&)>& error) {
  const std::size_t bricks = grid.tree().leafCount();
  BrickField field = fieldFor(grid, bricks);
  BrickValues values;
  float deepest = field.interior();
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    file.readLeaf(values.data());
    if (const std::string fault = faultOf(grid, *leaf, values); !fault.empty()) return fail(error(fault));
    deepest = std::min(deepest, *std::min_element(values.begin(), values.end()));
    field.add(brickOf(toVec(leaf->origin())), values);
    adviseOnFirst(field, bricks);
  }
  markTiles(grid, field);
  // A thin object has no inner brick that gives the width of its band.
  if (field.interiorBricks().empty()) field.setInterior(deepest);
  return field;
}

openvdb::GridBase::Ptr gridOf(const MaterialBricks& materials) {
  auto grid = openvdb::Int32Grid::create(0);
  grid->setName(kMaterialGrid);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(materials.voxel));
  internal::writeMaterialNames(materials.added, *grid);
  for (std::size_t b = 0; b < materials.bricks.size(); ++b) {
    const Vec3i n = materials.bricks[b] * kBrickSide;
    auto* leaf = new openvdb::Int32Tree::LeafNodeType(openvdb::Coord(n[0], n[1], n[2]));
    std::copy(materials.numbers[b].begin(), materials.numbers[b].end(), leaf->buffer().data());
    leaf->setValuesOn();
    grid->tree().addLeaf(leaf);
  }
  return grid;
}

}  // namespace

BrickField internal::toBricks(const openvdb::FloatGrid& grid) {
  const std::size_t bricks = grid.tree().leafCount();
  BrickField field = fieldFor(grid, bricks);
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    field.add(brickOf(toVec(leaf->origin())), std::span<const float, kBrickNodes>(leaf->buffer().data(), kBrickNodes));
    adviseOnFirst(field, bricks);
  }
  markTiles(grid, field);
  return field;
}

Expected<void> writeVdb(const std::filesystem::path& path, const std::vector<NamedField>& fields,
                        const std::map<std::string, std::string>& metadata, const MaterialBricks* materials) {
  openvdb::initialize();
  try {
    openvdb::GridPtrVec grids;
    for (const NamedField& named : fields) {
      const BrickField& field = *named.field;
      auto grid = openvdb::FloatGrid::create(field.background());
      grid->setName(named.name);
      grid->setGridClass(openvdb::GRID_LEVEL_SET);
      grid->setTransform(openvdb::math::Transform::createLinearTransform(field.voxel()));

      for (std::size_t b = 0; b < field.brickCount(); ++b) {
        const Vec3i n = field.brickCoord(b) * kBrickSide;
        auto* leaf = new openvdb::FloatTree::LeafNodeType(openvdb::Coord(n[0], n[1], n[2]));
        std::copy(field.brick(b).begin(), field.brick(b).end(), leaf->buffer().data());
        leaf->setValuesOn();
        grid->tree().addLeaf(leaf);
      }
      for (const Vec3i& brick : field.interiorBricks()) {  // without these tiles the inner bricks would read as outside
        const Vec3i n = brick * kBrickSide;
        grid->tree().addTile(1, openvdb::Coord(n[0], n[1], n[2]), field.interior(), false);
      }
      grids.push_back(grid);
    }
    if (materials && !materials->isEmpty()) grids.push_back(gridOf(*materials));

    openvdb::MetaMap meta;
    for (const auto& [key, value] : metadata) meta.insertMeta(key, openvdb::StringMetadata(value));
    return internal::writeGrids(path, openvdb::GridCPtrVec(grids.begin(), grids.end()), meta,
                                openvdb::io::Archive::DEFAULT_COMPRESSION_FLAGS);
  } catch (const std::exception& e) {
    return fail(
        {Error::Code::kWriteFailed, path.string(), "", e.what(), "a writable place with room", "free some space"});
  }
}

Expected<BrickField> readVdb(const std::filesystem::path& path, const std::string& name) {
  const std::string place = "grid " + name;
  const auto error = [&](const std::string& found) { return internal::vdbReadError(path, place, found); };
  try {
    KERF_CHECK(internal::requireVdbFile(path));
    KERF_CHECK(internal::checkVdbGrid(path, name, "Tree_float_5_4_3"));
    internal::VdbGridFile file(path);
    const openvdb::GridBase::Ptr any = file.open(name);
    if (!any) return fail(error("no such grid"));
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(any);
    if (!grid) return fail(error("a grid of another type than float"));
    KERF_CHECK(internal::requireUniformScale(*grid, path, place));
    if (!(grid->background() > 0 && std::isfinite(grid->background())))
      return fail(error(fmt::format("a background of {} mm", grid->background())));

    if (const std::string fault = faultOf(*grid); !fault.empty()) return fail(error(fault));
    return readBricks(file, *grid, error);
  } catch (const std::exception& e) {
    return fail(internal::vdbReadError(path, place, e));
  }
}

}  // namespace kerf
