#include "geometry/field/material_field.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>

#include "geometry/field/vdb_check.h"

namespace kerf {

struct MaterialField::Grid {
  openvdb::Int32Grid::ConstPtr labels;
  double voxel = 0;
};

MaterialField::MaterialField(std::shared_ptr<const Grid> grid) : grid_(std::move(grid)) {}
double MaterialField::voxel() const { return grid_->voxel; }

Material MaterialField::at(const Vec3i& node) const {
  const std::int32_t label = grid_->labels->tree().getValue({node[0], node[1], node[2]});
  return label >= 0 && label <= 255 ? static_cast<Material>(label) : Material::kNone;
}

bool MaterialField::copyBrick(const Vec3i& brick, std::span<std::uint8_t, 512> out) const {
  const auto number = [](std::int32_t label) {
    return static_cast<std::uint8_t>(label >= 0 && label <= 255 ? label : 0);
  };

  const openvdb::Coord origin(8 * brick[0], 8 * brick[1], 8 * brick[2]);
  const auto* leaf = grid_->labels->tree().probeConstLeaf(origin);
  if (!leaf) {
    std::fill(out.begin(), out.end(), number(grid_->labels->tree().getValue(origin)));
    return true;
  }
  const std::int32_t* const labels = leaf->buffer().data();
  for (std::size_t n = 0; n < 512; ++n) out[n] = number(labels[n]);
  return std::all_of(out.begin(), out.end(), [&](std::uint8_t label) { return label == out[0]; });
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

namespace {

constexpr std::int32_t kMostLabel = 255;

// The first number that no material has; empty: none.
std::string unknownLabel(const openvdb::Int32Grid& grid) {
  const auto isUnknown = [](std::int32_t label) { return label < 0 || label > kMostLabel; };
  const auto say = [&grid](std::int32_t label, const openvdb::Coord& at) {
    const openvdb::Vec3d p = grid.indexToWorld(at);
    return fmt::format("material {} at voxel {}, {}, {}, which is {:.3f}, {:.3f}, {:.3f} mm; materials are 0 to {}",
                       label, at.x(), at.y(), at.z(), p.x(), p.y(), p.z(), kMostLabel);
  };

  if (isUnknown(grid.background())) return fmt::format("material {} as background", grid.background());
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(openvdb::Int32Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile)
    if (isUnknown(tile.getValue())) return say(tile.getValue(), tile.getCoord());

  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    const std::int32_t* const labels = leaf->buffer().data();
    const std::int32_t* const end = labels + openvdb::Int32Tree::LeafNodeType::SIZE;
    const std::int32_t* const bad = std::find_if(labels, end, isUnknown);
    if (bad != end) return say(*bad, leaf->offsetToGlobalCoord(static_cast<openvdb::Index>(bad - labels)));
  }
  return {};
}

}  // namespace

Expected<MaterialField> readMaterialField(const std::filesystem::path& vdb) {
  const auto error = [&vdb](const std::string& found) {
    return fail({.code = Error::Code::kUnreadable,
                 .file = vdb.string(),
                 .place = "grid material",
                 .found = found,
                 .expected = "an OpenVDB file written by Kerf",
                 .hint = "bake the case again"});
  };
  try {
    openvdb::initialize();
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(vdb, ignored)) return error("no regular file");
    KERF_CHECK(internal::checkVdbGrid(vdb, "material", "Tree_int32_5_4_3"));
    openvdb::io::File file(vdb.string());
    file.open(false);
    if (!file.hasGrid("material")) return error("no such grid");
    const auto labels = openvdb::gridPtrCast<openvdb::Int32Grid>(file.readGrid("material"));
    if (!labels) return error("a grid of another type than int32");

    const openvdb::math::Transform& transform = labels->transform();
    if (!transform.isLinear() || !transform.hasUniformScale() ||
        transform.indexToWorld(openvdb::Vec3d(0)).length() != 0)
      return error("a transform that is more than a uniform scale");

    auto grid = std::make_shared<MaterialField::Grid>();
    grid->labels = labels;
    grid->voxel = transform.voxelSize()[0];
    if (!(grid->voxel >= 1e-3 && grid->voxel <= 100)) return error(fmt::format("a voxel size of {} mm", grid->voxel));
    if (const std::string fault = unknownLabel(*labels); !fault.empty()) return error(fault);
    return MaterialField(std::move(grid));
  } catch (const std::exception& e) {
    return error(e.what());
  }
}

}  // namespace kerf
