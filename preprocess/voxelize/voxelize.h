// Closed mesh -> signed distance field, material labels and point shell, as OpenVDB grids ready for the case bundle.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/field/brick_field.h"
#include "geometry/field/fine_region.h"
#include "geometry/field/material.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

struct VoxelizeOptions {
  double voxel_mm = 0.1;       ///< node spacing; below ~0.02 memory exceeds a lab computer
  double exterior_voxels = 3;  ///< band outside, in voxels: export needs 3
  double interior_voxels = 4;  ///< band inside, at least; also at least interior_mm. A clamped band biases force
  double interior_mm = 0.2;
  Material material = Material::kGeneric;  ///< material of nodes without a claim
  std::string material_names{};            ///< "1 enamel, 2 dentin": stored beside the labels, for readers of the file
  std::uint64_t max_bytes = 6ull << 30;    ///< limit of the estimate; above, the error names a voxel size that fits
};

/// A layer under the object's surface.
struct DepthRule {
  double depth_mm = 0;           ///< applies to nodes less deep than this; > 0
  std::optional<Plane> above{};  ///< and above this plane
};

/// Rule that gives places a material: exactly one of `solid`, `depth` and `covers`.
struct MaterialClaim {
  Material material = Material::kGeneric;
  const Mesh* solid = nullptr;  ///< inside this closed, crossing-free mesh, mm
  std::optional<DepthRule> depth{};
  std::function<bool(const Vec3d&)> covers{};  ///< predicate for any point, mm; called from many threads at once
  std::vector<Material> replaces{};            ///< for a solid or depth: applies only over these materials of later
                                               ///< claims
};

/// Distribution of the object's volume, mm^3.
struct MaterialVolumes {
  std::vector<double> claimed_mm3;  ///< per claim, in their order; filled gaps included
  double unclaimed_mm3 = 0;         ///< covered by no claim
  double forgotten_mm3 = 0;         ///< part of unclaimed_mm3 too far from every claim to be a gap: gets
                                    ///< VoxelizeOptions::material
};

struct AnatomyStats {
  std::uint64_t active_voxels = 0, shell_points = 0, bytes = 0;
  double volume_mm3 = 0;      ///< volume of {phi < 0}, the share of each voxel by a ramp one voxel wide
  double shell_area_mm2 = 0;  ///< sum of the shell's area weights
  MaterialVolumes materials;
};

/// The baked grids `phi` (mm, negative inside), `material` and `shell`, behind one pointer so that OpenVDB stays in the
/// .cpp.
class Anatomy {
 public:
  struct Grids;
  explicit Anatomy(std::unique_ptr<Grids> grids);
  Anatomy(Anatomy&&) noexcept;
  Anatomy& operator=(Anatomy&&) noexcept;
  ~Anatomy();

  const AnatomyStats& stats() const;
  /// Writes all grids into one .vdb file, those of `fine` as `phi_fine`, `material_fine`, `shell_fine`. Not atomic:
  /// meant for a staging folder.
  Expected<void> write(const std::filesystem::path& path, const Anatomy* fine = nullptr) const;

 private:
  std::unique_ptr<Grids> grids_;
};

inline constexpr double kSmallestVoxel = 0.005, kLargestVoxel = 5;  ///< mm
/// Requires a size between those two; NaN is an error.
Expected<void> checkVoxelSize(double voxel_mm);

/// Estimated peak memory of voxelizing, bytes; accurate to a factor of 2.
std::uint64_t estimateBakeBytes(const Mesh& solid, const VoxelizeOptions& options,
                                std::span<const MaterialClaim> claims = {});

/// Narrow-band field by OpenVDB's meshToVolume, cavities included (each nesting level separately: the library fills
/// voids that its flood fill cannot reach). The shell holds the nodes |phi| < 1.5 voxels with inward normal, area
/// weight delta_e(phi) |grad phi| h^3 and material.
/// @pre mesh closed, oriented, free of self-intersections; coordinates in mm.
/// Materials: the first claim that covers a node wins; gaps between claims, up to 8 voxels, go to their neighbours, the
/// rest gets `options.material`. Labels cover the whole shell.
/// Parallel on all cores; the result does not depend on their number. Cancellation leaves nothing behind.
Expected<Anatomy> voxelize(const Mesh& solid, const VoxelizeOptions& options, const Progress& progress = {},
                           std::span<const MaterialClaim> claims = {});

/// The same at the voxel size of a region, and only in the bricks of the region, with memory only for its box. Near its
/// border too the field is the distance to the object's surface, not to the end of the region. Fails with kEmpty when
/// the region does not meet the object's surface. `options.voxel_mm` is not used.
Expected<Anatomy> voxelizeRegion(const Mesh& solid, const FineRegion& region, const VoxelizeOptions& options,
                                 const Progress& progress = {}, std::span<const MaterialClaim> claims = {});

/// The bare library call on the same mesh with the same bands, for the benchmark's ratio. Returns seconds.
Expected<double> timeBareMeshToVolume(const Mesh& solid, const VoxelizeOptions& options);

}  // namespace kerf
