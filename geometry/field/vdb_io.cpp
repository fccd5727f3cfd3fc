#include "geometry/field/vdb_io.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include <cmath>
#include <mutex>

#include "geometry/base/large_pages.h"
#include "geometry/field/vdb_bricks.h"
#include "geometry/field/vdb_check.h"
#include "geometry/field/vdb_writer.h"

namespace kerf {
namespace {

static_assert(openvdb::FloatTree::LeafNodeType::SIZE == kBrickNodes, "a brick is one OpenVDB leaf");

void initialize() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

Error readError(const std::filesystem::path& path, const std::string& place, const std::string& found) {
  return {Error::Code::kUnreadable,          path.string(),        place, found,
          "an OpenVDB file written by Kerf", "bake the case again"};
}

Vec3i toVec(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

}  // namespace

namespace {

// Bricks deep inside that a file may state: a mandible at 0.05 mm has about one million. They need no bytes of their
// own, so a small file could state any number. A band of n leaves encloses fewer than n^1.5 bricks, and a fine region
// that lies inside tissue has no band at all.
constexpr std::int64_t kMostInterior = 16'000'000, kInteriorWithoutBand = 1'000'000;

std::string placeOf(const openvdb::FloatGrid& grid, const openvdb::Coord& at) {
  const openvdb::Vec3d p = grid.indexToWorld(at);
  return fmt::format("at voxel {}, {}, {}, which is {:.3f}, {:.3f}, {:.3f} mm", at.x(), at.y(), at.z(), p.x(), p.y(),
                     p.z());
}

bool isFar(const openvdb::CoordBBox& box) {
  constexpr int kFarthest = 1 << (20 + kBrickLog);  // coordKey
  return openvdb::Coord::lessThan(box.min(), openvdb::Coord(-kFarthest)) ||
         openvdb::Coord::lessThan(openvdb::Coord(kFarthest - 1), box.max());
}

// What no field of ours holds, and what would be cut as if it were tissue, or take all memory. Empty: nothing.
std::string faultOf(const openvdb::FloatGrid& grid) {
  const double most = 1000 * grid.voxelSize()[0];  // mm; bands are a few voxels wide
  const auto isBeyond = [&](float value) { return !(std::abs(static_cast<double>(value)) <= most); };

  const double leaves = static_cast<double>(grid.tree().leafCount());
  const std::int64_t most_interior =
      std::min(kMostInterior, kInteriorWithoutBand + static_cast<std::int64_t>(std::min(1e9, std::pow(leaves, 1.5))));
  std::int64_t interior = 0;
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (isBeyond(tile.getValue()))
      return fmt::format("a tile of {} mm {}", tile.getValue(), placeOf(grid, tile.getCoord()));
    if (tile.getValue() >= 0) continue;
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    if (isFar(box)) return "tiles too far from the origin, " + placeOf(grid, box.min());
    interior += static_cast<std::int64_t>(box.volume() / kBrickNodes);
    if (interior > most_interior)
      return fmt::format("more than {} bricks deep inside a band of {} bricks", most_interior, leaves);
  }

  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    if (isFar(leaf->getNodeBoundingBox())) return "voxels too far from the origin, " + placeOf(grid, leaf->origin());
    const float* const values = leaf->buffer().data();
    const float* const bad = std::find_if(values, values + kBrickNodes, isBeyond);
    if (bad == values + kBrickNodes) continue;
    const openvdb::Coord at = leaf->offsetToGlobalCoord(static_cast<openvdb::Index>(bad - values));
    return fmt::format("{} mm {}", *bad, placeOf(grid, at));
  }
  return {};
}

}  // namespace

BrickField internal::toBricks(const openvdb::FloatGrid& grid) {
  float interior = 0;  // the deepest constant inside; a file without interior tiles has none to tell
  auto deep = grid.tree().cbeginValueAll();
  deep.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; deep; ++deep) interior = std::min(interior, deep.getValue());

  BrickField field(grid.voxelSize()[0], grid.background(), interior < 0 ? interior : -grid.background());
  field.reserve(grid.tree().leafCount());
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    field.add(brickOf(toVec(leaf->origin())), std::span<const float, kBrickNodes>(leaf->buffer().data(), kBrickNodes));
    // The first brick tells where the reserved memory is; the rest of it has not been touched yet.
    if (field.brickCount() == 1)
      internal::adviseLargePages(&field.brick(0), grid.tree().leafCount() * sizeof(BrickValues));
  }

  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (tile.getValue() >= 0) continue;
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    const Vec3i low = brickOf(toVec(box.min())), high = brickOf(toVec(box.max()));
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int z = low[2]; z <= high[2]; ++z) field.markInterior({x, y, z});
  }
  return field;
}

Expected<void> writeVdb(const std::filesystem::path& path, const std::vector<NamedField>& fields,
                        const std::map<std::string, std::string>& metadata) {
  initialize();
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
      for (const Vec3i& brick : field.interiorBricks()) {  // without these tiles the deep inside would read as outside
        const Vec3i n = brick * kBrickSide;
        grid->tree().addTile(1, openvdb::Coord(n[0], n[1], n[2]), field.interior(), false);
      }
      grids.push_back(grid);
    }

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
  initialize();
  try {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored))
      return fail(readError(path, "file", std::filesystem::exists(path, ignored) ? "no regular file" : "no such file"));
    KERF_CHECK(internal::checkVdbGrid(path, name, "Tree_float_5_4_3"));
    openvdb::io::File file(path.string());
    file.open(false);
    if (!file.hasGrid(name)) return fail(readError(path, "grid " + name, "no such grid"));
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(name));
    if (!grid) return fail(readError(path, "grid " + name, "a grid of another type than float"));
    const openvdb::math::Transform& transform = grid->transform();
    if (!transform.isLinear() || !transform.hasUniformScale() ||
        transform.indexToWorld(openvdb::Vec3d(0)).length() != 0)
      return fail(readError(path, "grid " + name, "a transform that is more than a uniform scale"));

    const double voxel = transform.voxelSize()[0];
    if (!(voxel >= 1e-3 && voxel <= 100))
      return fail(readError(path, "grid " + name, fmt::format("a voxel size of {} mm", voxel)));
    if (!(grid->background() > 0 && std::isfinite(grid->background())))
      return fail(readError(path, "grid " + name, fmt::format("a background of {} mm", grid->background())));

    if (const std::string fault = faultOf(*grid); !fault.empty()) return fail(readError(path, "grid " + name, fault));
    return internal::toBricks(*grid);
  } catch (const std::exception& e) {
    return fail(readError(path, "", e.what()));
  }
}

}  // namespace kerf
