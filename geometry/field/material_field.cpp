#include "geometry/field/material_field.h"

#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "geometry/base/large_pages.h"
#include "geometry/field/brick_field.h"
#include "geometry/field/material_bricks.h"
#include "geometry/field/vdb_check.h"
#include "geometry/field/vdb_reader.h"

namespace kerf {

// The stored tree, without the values of its leaves: these would take four times the memory of the numbers, and most
// leaves have one material.
struct MaterialField::Grid {
  using Leaf = openvdb::Int32Tree::LeafNodeType;
  using Numbers = std::array<std::uint8_t, kBrickNodes>;

  openvdb::Int32Grid::Ptr labels;  // a leaf's transient data: its one material, or kMixed and more the place in `mixed`
  std::vector<Numbers> mixed;
  double voxel = 0;

  // In the place of all of the above: labels of a case, and bricks that have others.
  std::optional<MaterialField> below;
  MaterialBricks over;

  static constexpr openvdb::Index32 kMixed = 256;
  static constexpr std::int32_t kMostLabel = 255;

  static std::uint8_t number(std::int32_t label) {
    return static_cast<std::uint8_t>(label >= 0 && label <= 255 ? label : 0);
  }
  // Null: all of the leaf is of one material.
  const Numbers* numbersOf(const Leaf& leaf) const {
    return leaf.transientData() < kMixed ? nullptr : &mixed[leaf.transientData() - kMixed];
  }

  static bool isUnknown(std::int32_t label) { return label < 0 || label > kMostLabel; }
  std::string unknown(std::int32_t label, const openvdb::Coord& at) const {
    return fmt::format("material {} {}; materials are 0 to {}", label, internal::vdbPlace(*labels, at), kMostLabel);
  }

  // The first number outside the leaves that no material has; empty: none.
  std::string faultOfTiles() const {
    if (isUnknown(labels->background())) return fmt::format("material {} as background", labels->background());
    auto tile = labels->tree().cbeginValueAll();
    tile.setMaxDepth(openvdb::Int32Tree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile)
      if (isUnknown(tile.getValue())) return unknown(tile.getValue(), tile.getCoord());
    return {};
  }

  // Returns the first number that no material has; empty: none.
  std::string read(internal::VdbGridFile& file) {
    mixed.reserve(labels->tree().leafCount());  // unused memory is never touched
    internal::adviseLargePages(static_cast<void*>(mixed.data()), mixed.capacity() * sizeof(Numbers));
    Numbers numbers;
    std::array<std::int32_t, kBrickNodes> values;
    for (auto leaf = labels->tree().beginLeaf(); leaf; ++leaf) {
      file.readLeaf(values.data());
      if (const auto bad = std::find_if(values.begin(), values.end(), isUnknown); bad != values.end())
        return unknown(*bad, leaf->offsetToGlobalCoord(static_cast<openvdb::Index>(bad - values.begin())));
      std::transform(values.begin(), values.end(), numbers.begin(), number);
      const bool is_one = std::all_of(numbers.begin(), numbers.end(), [&](auto one) { return one == numbers[0]; });
      leaf->setTransientData(is_one ? numbers[0] : kMixed + static_cast<openvdb::Index32>(mixed.size()));
      if (!is_one) mixed.push_back(numbers);
    }
    return {};
  }
};

MaterialField::MaterialField(std::shared_ptr<const Grid> grid) : grid_(std::move(grid)) {}
double MaterialField::voxel() const { return grid_->voxel; }

Material MaterialField::at(const Vec3i& node) const {
  if (grid_->below) {
    const MaterialBricks::Numbers* const over = grid_->over.find(brickOf(node));
    if (!over) return grid_->below->at(node);
    return static_cast<Material>((*over)[static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]))]);
  }
  const openvdb::Coord coord(node[0], node[1], node[2]);
  const Grid::Leaf* const leaf = grid_->labels->constTree().probeConstLeaf(coord);
  if (!leaf) return static_cast<Material>(Grid::number(grid_->labels->constTree().getValue(coord)));
  const Grid::Numbers* const numbers = grid_->numbersOf(*leaf);
  return static_cast<Material>(numbers ? (*numbers)[Grid::Leaf::coordToOffset(coord)] : leaf->transientData());
}

std::optional<Material> MaterialField::oneOf(const Vec3i& brick) const {
  if (grid_->below) {
    const MaterialBricks::Numbers* const over = grid_->over.find(brick);
    if (!over) return grid_->below->oneOf(brick);
    const bool is_one = std::all_of(over->begin(), over->end(), [&](auto number) { return number == over->front(); });
    return is_one ? std::optional(static_cast<Material>(over->front())) : std::nullopt;
  }
  const openvdb::Coord origin(8 * brick[0], 8 * brick[1], 8 * brick[2]);
  const Grid::Leaf* const leaf = grid_->labels->constTree().probeConstLeaf(origin);
  if (!leaf) return static_cast<Material>(Grid::number(grid_->labels->constTree().getValue(origin)));
  if (grid_->numbersOf(*leaf)) return std::nullopt;
  return static_cast<Material>(leaf->transientData());
}

bool MaterialField::copyBrick(const Vec3i& brick, std::span<std::uint8_t, 512> out) const {
  if (const std::optional<Material> one = oneOf(brick)) {
    std::fill(out.begin(), out.end(), static_cast<std::uint8_t>(*one));
    return true;
  }
  if (grid_->below) {
    const MaterialBricks::Numbers* const over = grid_->over.find(brick);
    if (!over) return grid_->below->copyBrick(brick, out);
    std::copy_n(over->begin(), out.size(), out.begin());
    return false;
  }
  const Grid::Leaf* const leaf = grid_->labels->constTree().probeConstLeaf({8 * brick[0], 8 * brick[1], 8 * brick[2]});
  std::copy_n(grid_->numbersOf(*leaf)->begin(), out.size(), out.begin());
  return false;
}

Material MaterialField::near(const Vec3d& p) const {
  const Vec3d x = p / grid_->voxel;
  const Vec3i nearest = x.array().round().cast<int>().matrix();
  if (const Material there = at(nearest); there != Material::kNone) return there;

  Material best = Material::kNone;
  double best_squared = std::numeric_limits<double>::infinity();
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = -2; k <= 2; ++k) {
        const Vec3i node = nearest + Vec3i(i, j, k);
        const double squared = (node.cast<double>() - x).squaredNorm();
        if (squared >= best_squared) continue;
        if (const Material there = at(node); there != Material::kNone) {
          best = there;
          best_squared = squared;
        }
      }
  return best;
}

MaterialField laidOver(MaterialField in_case, MaterialBricks bricks) {
  if (bricks.isEmpty()) return in_case;
  auto grid = std::make_shared<MaterialField::Grid>();
  grid->voxel = in_case.voxel();
  grid->below = std::move(in_case);
  grid->over = std::move(bricks);
  return MaterialField(std::move(grid));
}

Expected<MaterialField> readMaterialField(const std::filesystem::path& vdb) {
  const std::string place = "grid material";
  const auto error = [&](const std::string& found) { return fail(internal::vdbReadError(vdb, place, found)); };
  try {
    KERF_CHECK(internal::requireVdbFile(vdb));
    KERF_CHECK(internal::checkVdbGrid(vdb, "material", "Tree_int32_5_4_3"));
    internal::VdbGridFile file(vdb);
    const openvdb::GridBase::Ptr any = file.open("material");
    if (!any) return error("no such grid");
    const auto labels = openvdb::gridPtrCast<openvdb::Int32Grid>(any);
    if (!labels) return error("a grid of another type than int32");
    KERF_CHECK(internal::requireUniformScale(*labels, vdb, place));

    auto grid = std::make_shared<MaterialField::Grid>();
    grid->labels = labels;
    grid->voxel = labels->voxelSize()[0];
    if (const std::string fault = grid->faultOfTiles(); !fault.empty()) return error(fault);
    if (const std::string fault = grid->read(file); !fault.empty()) return error(fault);
    return MaterialField(std::move(grid));
  } catch (const std::exception& e) {
    return fail(internal::vdbReadError(vdb, place, e));
  }
}

}  // namespace kerf
