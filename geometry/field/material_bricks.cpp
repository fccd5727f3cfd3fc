#include "geometry/field/material_bricks.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "geometry/field/vdb_check.h"
#include "geometry/field/vdb_io.h"
#include "geometry/field/vdb_material_names.h"
#include "geometry/field/vdb_reader.h"

namespace kerf {
namespace {

bool isMaterial(std::int32_t number) { return number >= 1 && number <= 255; }

std::string noMaterial(const openvdb::Int32Grid& grid, std::int32_t number, const openvdb::Coord& at) {
  return fmt::format("material {} {}; materials are 1 to 255", number, internal::vdbPlace(grid, at));
}

// Checks that the grid has no values outside its leaves. Empty if so.
std::string faultOfTiles(const openvdb::Int32Grid& grid) {
  if (grid.background() != 0) return fmt::format("material {} as background", grid.background());
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(openvdb::Int32Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile)
    if (tile.getValue() != 0)
      return fmt::format("a tile of material {} {}", tile.getValue(), internal::vdbPlace(grid, tile.getCoord()));
  return {};
}

// The grid's leaves, in the order of the file. Returns the first error; empty if none.
std::string readLeaves(internal::VdbGridFile& file, const openvdb::Int32Grid& grid, MaterialBricks& out) {
  const std::size_t count = grid.tree().leafCount();
  out.bricks.reserve(count);
  out.numbers.reserve(count);
  std::array<std::int32_t, kBrickNodes> values;
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    file.readLeaf(values.data());
    const auto bad = std::find_if_not(values.begin(), values.end(), isMaterial);
    if (bad != values.end())
      return noMaterial(grid, *bad, leaf->offsetToGlobalCoord(static_cast<openvdb::Index>(bad - values.begin())));

    const openvdb::Coord& at = leaf->origin();
    out.bricks.push_back(brickOf({at.x(), at.y(), at.z()}));
    std::transform(values.begin(), values.end(), out.numbers.emplace_back().begin(),
                   [](std::int32_t value) { return static_cast<std::uint8_t>(value); });
  }
  return {};
}

void sortByKey(MaterialBricks& bricks) {
  std::vector<std::size_t> order(bricks.bricks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return coordKey(bricks.bricks[a]) < coordKey(bricks.bricks[b]); });

  std::vector<Vec3i> sorted;
  std::vector<MaterialBricks::Numbers> numbers;
  sorted.reserve(order.size());
  numbers.reserve(order.size());
  for (const std::size_t n : order) {
    sorted.push_back(bricks.bricks[n]);
    numbers.push_back(bricks.numbers[n]);
  }
  bricks.bricks = std::move(sorted);
  bricks.numbers = std::move(numbers);
}

tl::unexpected<Error> refuse(const MaterialBricks& bricks, std::string found, std::string expected) {
  return fail({.code = Error::Code::kBadValue,
               .file = bricks.file.string(),
               .place = std::string("grid ") + kMaterialGrid,
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = "runs must not be edited: restore it from a copy, or cut again"});
}

std::string listOf(const std::map<std::uint8_t, std::string>& added) {
  std::string out;
  for (const auto& [number, id] : added) out += fmt::format("{}{} ({})", out.empty() ? "" : ", ", number, id);
  return out.empty() ? "none" : out;
}

}  // namespace

const MaterialBricks::Numbers* MaterialBricks::find(const Vec3i& brick) const {
  const std::uint64_t key = coordKey(brick);
  const auto isBefore = [](const Vec3i& at, std::uint64_t wanted) { return coordKey(at) < wanted; };
  const auto at = std::lower_bound(bricks.begin(), bricks.end(), key, isBefore);
  if (at == bricks.end() || coordKey(*at) != key) return nullptr;
  return &numbers[static_cast<std::size_t>(at - bricks.begin())];
}

Expected<MaterialBricks> readMaterialBricks(const std::filesystem::path& vdb) {
  const std::string place = std::string("grid ") + kMaterialGrid;
  const auto error = [&](const std::string& found) { return fail(internal::vdbReadError(vdb, place, found)); };
  try {
    KERF_TRY(grids, inspectVdb(vdb));
    const auto isWanted = [](const VdbGridInfo& grid) { return grid.name == kMaterialGrid; };
    if (std::none_of(grids.begin(), grids.end(), isWanted)) return MaterialBricks{};

    KERF_CHECK(internal::checkVdbGrid(vdb, kMaterialGrid, "Tree_int32_5_4_3"));
    internal::VdbGridFile file(vdb);
    const openvdb::GridBase::Ptr any = file.open(kMaterialGrid);
    const auto grid = any ? openvdb::gridPtrCast<openvdb::Int32Grid>(any) : nullptr;
    if (!grid) return error("a grid of another type than int32");
    KERF_CHECK(internal::requireUniformScale(*grid, vdb, place));
    if (const std::string fault = faultOfTiles(*grid); !fault.empty()) return error(fault);

    MaterialBricks out;
    out.voxel = grid->voxelSize()[0];
    out.file = vdb;
    if (const std::string fault = readLeaves(file, *grid, out); !fault.empty()) return error(fault);
    sortByKey(out);
    out.added = internal::materialNamesOf(*grid);
    return out;
  } catch (const std::exception& e) {
    return fail(internal::vdbReadError(vdb, place, e));
  }
}

Expected<void> requireOnlyAdded(const MaterialBricks& bricks, const MaterialField& in_case, Material fallback) {
  if (bricks.isEmpty()) return {};
  if (bricks.voxel != in_case.voxel())
    return refuse(bricks, fmt::format("voxels of {:g} mm", bricks.voxel),
                  fmt::format("{:g} mm, as in the case", in_case.voxel()));

  MaterialBricks::Numbers before;
  for (std::size_t b = 0; b < bricks.bricks.size(); ++b) {
    in_case.copyBrick(bricks.bricks[b], before);
    std::replace(before.begin(), before.end(), std::uint8_t{0}, static_cast<std::uint8_t>(fallback));
    for (int node = 0; node < kBrickNodes; ++node) {
      const auto n = static_cast<std::size_t>(node);
      const std::uint8_t number = bricks.numbers[b][n];
      if (number == before[n] || bricks.added.contains(number)) continue;
      const Vec3d p = bricks.voxel *
                      (kBrickSide * bricks.bricks[b] + Vec3i{node >> (2 * kBrickLog), node >> kBrickLog & 7, node & 7})
                          .cast<double>();
      return refuse(bricks,
                    fmt::format("material {} at ({:.2f}, {:.2f}, {:.2f}) mm, where the case has {}", number, p.x(),
                                p.y(), p.z(), before[n]),
                    "the case's, or added material: " + listOf(bricks.added));
    }
  }
  return {};
}

}  // namespace kerf
