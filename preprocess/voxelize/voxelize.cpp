#include "preprocess/voxelize/voxelize.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "geometry/base/available_memory.h"
#include "geometry/boolean/boolean.h"
#include "geometry/field/vdb_writer.h"
#include "preprocess/voxelize/cropped_bricks.h"
#include "preprocess/voxelize/mesh_field.h"
#include "preprocess/voxelize/paint_materials.h"
#include "preprocess/voxelize/point_shell.h"

namespace kerf {

struct Anatomy::Grids {
  openvdb::FloatGrid::Ptr phi;
  openvdb::Int32Grid::Ptr material;
  openvdb::GridBase::Ptr shell;
  AnatomyStats stats;
};

Anatomy::Anatomy(std::unique_ptr<Grids> grids) : grids_(std::move(grids)) {}
Anatomy::Anatomy(Anatomy&&) noexcept = default;
Anatomy& Anatomy::operator=(Anatomy&&) noexcept = default;
Anatomy::~Anatomy() = default;
const AnatomyStats& Anatomy::stats() const { return grids_->stats; }

Expected<void> Anatomy::write(const std::filesystem::path& path, const Anatomy* fine) const {
  openvdb::GridCPtrVec grids{grids_->phi, grids_->material, grids_->shell};
  if (fine)
    for (const openvdb::GridBase::Ptr& grid :
         openvdb::GridPtrVec{fine->grids_->phi, fine->grids_->material, fine->grids_->shell}) {
      const openvdb::GridBase::Ptr renamed = grid->copyGrid();  // shares the tree
      renamed->setName(grid->getName() + kFineSuffix);
      grids.push_back(renamed);
    }
  // Blosc: half the time of zip on these grids, a fifth larger.
  return internal::writeGrids(path, grids, {}, openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
}

namespace {

internal::Bands bandsOf(const VoxelizeOptions& o) {
  return {static_cast<float>(o.exterior_voxels),
          static_cast<float>(std::max(o.interior_voxels, o.interior_mm / o.voxel_mm))};
}

}  // namespace

std::uint64_t estimateBakeBytes(const Mesh& solid, const VoxelizeOptions& options,
                                std::span<const MaterialClaim> claims) {
  // Per mm^2 of surface a band of leaves about (bands + 8) voxels thick. The field and the library's working copy of it
  // (distance, nearest triangle) cost about 14 bytes a voxel, materials and shell 12 more.
  const double h = options.voxel_mm, area = surfaceArea(solid) / (h * h);
  const auto layers = [](const internal::Bands& b) { return static_cast<double>(b.exterior + b.interior) + 8; };
  const double field = area * layers(bandsOf(options)) * 26;
  double most = 0;  // peak temporary memory of one claim
  for (const MaterialClaim& claim : claims) {
    if (claim.solid) most = std::max(most, surfaceArea(*claim.solid) / (h * h) * layers({1, 1}) * 14);
    if (claim.depth) most = std::max(most, area * layers({1, static_cast<float>(claim.depth->depth_mm / h)}) * 18);
  }
  // With claims the labels exist voxel by voxel before uniform regions merge again.
  const double labels = claims.empty() ? 0 : std::max(0.0, signedVolume(solid)) / (h * h * h) * 4.2;
  return static_cast<std::uint64_t>(field + most + labels);
}

Expected<void> checkVoxelSize(double voxel_mm) {
  if (voxel_mm >= kSmallestVoxel && voxel_mm <= kLargestVoxel) return {};
  return fail({.code = Error::Code::kBadValue,
               .place = "voxel size",
               .found = fmt::format("{} mm", voxel_mm),
               .expected = fmt::format("{} to {} mm", kSmallestVoxel, kLargestVoxel),
               .hint = "0.1 for an arch, 0.05 for a tooth"});
}

namespace {

// Hint for voxels of a size that fits into memory.
std::string hintOfSize(double fits_mm, bool is_region, double across_mm) {
  constexpr double kLargestObject = 300;  // mm across: a skull
  if (is_region && fits_mm <= kLargestVoxel)
    return fmt::format("--fine-voxel {0:.3f}, or voxel = {0:.3f} in the recipe's [region]", fits_mm);
  std::string unit = fmt::format("another --unit: the object is {:.0f} mm across", across_mm);
  if (fits_mm > kLargestVoxel) return unit;
  return fmt::format("--voxel {:.3f}", fits_mm) + (across_mm > kLargestObject ? ", or " + unit : "");
}

// Rejects voxels too small for the memory or for OpenVDB's coordinates.
Expected<void> checkSize(const FineRegion* region, const Mesh& solid, const VoxelizeOptions& options,
                         std::span<const MaterialClaim> claims) {
  const double h = options.voxel_mm;
  const std::uint64_t most = std::min(options.max_bytes, internal::availableMemory() / 5 * 4);
  const auto need = [&](double voxel_mm) {
    VoxelizeOptions o = options;
    o.voxel_mm = voxel_mm;
    return estimateBakeBytes(solid, o, claims);
  };
  if (need(h) > most) {
    double fits = h;
    while (need(fits) > most) fits *= 1.02;
    const double rounded = std::ceil(fits * 1000) / 1000;
    return fail({.code = Error::Code::kBadValue,
                 .place = "voxel size",
                 .found = fmt::format("{} mm would need about {:.1f} GB for {:.0f} mm2 of surface", h,
                                      static_cast<double>(need(h)) / 1e9, surfaceArea(solid)),
                 .expected = fmt::format("at most {:.1f} GB", static_cast<double>(most) / 1e9),
                 .hint = hintOfSize(rounded, region != nullptr, bounds(solid).size().norm())});
  }

  const Box3 box = bounds(solid);
  if ((box.max.cwiseAbs().cwiseMax(box.min.cwiseAbs()) / h).maxCoeff() > (1 << 20) * 7.0)
    return fail({.code = Error::Code::kBadValue,
                 .place = "position",
                 .found = "coordinates too far from the origin for this voxel size",
                 .hint = "a coarser --voxel"});
  return {};
}

// Field, materials and shell, in this order. Throws OpenVDB's exceptions.
Expected<Anatomy> makeGrids(const FineRegion* region, const Mesh& solid, const VoxelizeOptions& options,
                            const Progress& progress, std::span<const MaterialClaim> claims) {
  openvdb::initialize();
  internal::Interrupter interrupter(progress);
  auto grids = std::make_unique<Anatomy::Grids>();

  if (!interrupter.step(0.0, "distance field")) return cancelled();
  grids->phi = internal::meshField(solid, options.voxel_mm, bandsOf(options), interrupter);
  if (interrupter.isCancelled()) return cancelled();
  if (!grids->phi || grids->phi->tree().leafCount() == 0)
    return fail({.code = Error::Code::kEmpty,
                 .found = "no surface at this voxel size",
                 .expected = "a mesh larger than a voxel",
                 .hint = "a finer --voxel"});
  grids->phi->setName("phi");
  grids->phi->setGridClass(openvdb::GRID_LEVEL_SET);

  if (!interrupter.step(0.7, "materials")) return cancelled();
  AnatomyStats& stats = grids->stats;
  grids->material = internal::paintMaterials(solid, *grids->phi, options, claims, stats.materials, interrupter);
  if (!grids->material || !interrupter.step(0.9, "point shell")) return cancelled();

  const auto keep = [region](const openvdb::Coord& origin) {
    return !region || region->mayMeetBrick(brickOf({origin.x(), origin.y(), origin.z()}));
  };
  internal::PointShell shell = internal::makePointShell(*grids->phi, *grids->material, keep, interrupter);
  if (region) {
    grids->phi = internal::croppedBricks<openvdb::FloatGrid>(*grids->phi, keep);
    grids->material = internal::croppedBricks<openvdb::Int32Grid>(*grids->material, keep);
    if (shell.points == 0)
      return fail({.code = Error::Code::kEmpty,
                   .place = "fine region",
                   .found = "no surface of the object in it",
                   .expected = "a line on the object",
                   .hint = "check the line's frame and unit, or a larger radius"});
  }

  grids->shell = shell.grid;
  stats.shell_points = shell.points;
  stats.shell_area_mm2 = shell.area_mm2;
  stats.volume_mm3 = shell.volume_mm3;
  stats.active_voxels = grids->phi->activeVoxelCount();
  stats.bytes = grids->phi->memUsage() + grids->material->memUsage() + grids->shell->memUsage();
  if (!interrupter.step(1.0, "field, shell and materials")) return cancelled();
  return Anatomy(std::move(grids));
}

// With a region keeps only its bricks; the mesh is already clipped to a box around it.
Expected<Anatomy> voxelizeIn(const FineRegion* region, const Mesh& solid, const VoxelizeOptions& options,
                             const Progress& progress, std::span<const MaterialClaim> claims) {
  KERF_CHECK(checkVoxelSize(options.voxel_mm));
  KERF_CHECK(checkSize(region, solid, options, claims));
  try {
    return makeGrids(region, solid, options, progress, claims);
  } catch (const std::bad_alloc&) {
    return fail(
        {.code = Error::Code::kBadValue, .place = "voxel size", .found = "out of memory", .hint = "a coarser --voxel"});
  } catch (const std::exception& e) {
    return fail({.code = Error::Code::kGeometry,
                 .place = "distance field",
                 .found = e.what(),
                 .expected = "a closed mesh",
                 .hint = "kerf check on the mesh"});
  }
}

// The part of a closed mesh that can affect the fine region.
Expected<Mesh> partInBox(const Mesh& mesh, const Box3& box) {
  Expected<Mesh> part = clipToBox(mesh, box);
  if (part) return part;
  Error error = std::move(part).error();
  error.place = "fine region: " + error.place;
  error.hint = "kerf check on the mesh; or another radius";
  return fail(std::move(error));
}

}  // namespace

Expected<Anatomy> voxelize(const Mesh& solid, const VoxelizeOptions& options, const Progress& progress,
                           std::span<const MaterialClaim> claims) {
  return voxelizeIn(nullptr, solid, options, progress, claims);
}

Expected<Anatomy> voxelizeRegion(const Mesh& solid, const FineRegion& region, const VoxelizeOptions& options,
                                 const Progress& progress, std::span<const MaterialClaim> claims) {
  VoxelizeOptions fine = options;
  fine.voxel_mm = region.voxel_mm;
  KERF_CHECK(checkVoxelSize(fine.voxel_mm));

  // Reach of all inputs of the region's bricks: their own size, the bands, the depths, and filled gaps between claims.
  const internal::Bands bands = bandsOf(fine);
  double reach = static_cast<double>(bands.exterior + bands.interior) * fine.voxel_mm;
  for (const MaterialClaim& claim : claims)
    if (claim.depth) reach = std::max(reach, claim.depth->depth_mm);

  Box3 box = region.bounds();
  box.grow(reach + (2 * kBrickSide + 10) * fine.voxel_mm);
  KERF_TRY(clipped, partInBox(solid, box));
  if (clipped.triangles.empty())
    return fail({.code = Error::Code::kEmpty,
                 .place = "fine region",
                 .found = "it does not touch the object",
                 .expected = "a line on the object",
                 .hint = "check the line's frame and unit"});

  std::vector<MaterialClaim> near(claims.begin(), claims.end());
  std::vector<Mesh> solids(claims.size());
  for (std::size_t n = 0; n < near.size(); ++n) {
    if (!near[n].solid) continue;
    KERF_TRY(part, partInBox(*near[n].solid, box));
    solids[n] = std::move(part);
    near[n].solid = solids[n].triangles.empty() ? nullptr : &solids[n];
    if (!near[n].solid) near[n].covers = [](const Vec3d&) { return false; };
  }
  return voxelizeIn(&region, clipped, fine, progress, near);
}

Expected<double> timeBareMeshToVolume(const Mesh& solid, const VoxelizeOptions& options) {
  openvdb::initialize();
  const Progress silent;
  internal::Interrupter interrupter(silent);
  const auto start = std::chrono::steady_clock::now();
  const auto field = internal::bareMeshField(solid, options.voxel_mm, bandsOf(options), interrupter);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!field || field->empty()) return fail({.code = Error::Code::kEmpty, .found = "meshToVolume gave nothing"});
  return seconds;
}

}  // namespace kerf
