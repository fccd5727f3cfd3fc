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
  double voxel_mm = 0.1;       ///< node spacing; below ~0.02 memory grows past what a lab computer has
  double exterior_voxels = 3;  ///< band outside, in voxels: export needs 3
  double interior_voxels = 4;  ///< band inside, at least; also at least interior_mm. A clamped band biases force
  double interior_mm = 0.2;
  Material material = Material::kGeneric;  ///< where no claim says otherwise
  std::string material_names{};            ///< "1 enamel, 2 dentin": kept beside the labels for whoever opens the file
  std::uint64_t max_bytes = 6ull << 30;    ///< refuse, naming a voxel size that fits, when the estimate is above
};

/// A layer under the object's surface.
struct DepthRule {
  double depth_mm = 0;           ///< nodes less deep than this; > 0
  std::optional<Plane> above{};  ///< and above this plane
};

/// What says which material a place is made of: exactly one of `solid`, `depth` and `covers`.
struct MaterialClaim {
  Material material = Material::kGeneric;
  const Mesh* solid = nullptr;  ///< inside this closed, crossing-free mesh, mm
  std::optional<DepthRule> depth{};
  std::function<bool(const Vec3d&)> covers{};  ///< a question to ask for any point, mm, from many threads at once
  std::vector<Material> replaces{};            ///< of a solid or depth: holds only where a later claim put one of these
};

/// Where the object's volume went, mm^3.
struct MaterialVolumes {
  std::vector<double> claimed_mm3;  ///< per claim, in their order; gaps that were filled included
  double unclaimed_mm3 = 0;         ///< covered by no claim
  double forgotten_mm3 = 0;         ///< of that, too far from every claim to be a gap: got VoxelizeOptions::material
};

struct AnatomyStats {
  std::uint64_t active_voxels = 0, shell_points = 0, bytes = 0;
  double volume_mm3 = 0;      ///< of {phi < 0}, the share of each voxel by a ramp one voxel wide
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
/// Between those two; not a number is refused like any other.
Expected<void> checkVoxelSize(double voxel_mm);

/// Bytes that voxelizing will need at peak; good to a factor of 2.
std::uint64_t estimateBakeBytes(const Mesh& solid, const VoxelizeOptions& options,
                                std::span<const MaterialClaim> claims = {});

/// Narrow-band field by OpenVDB's meshToVolume, cavities included (each nesting level apart: the library fills voids
/// that its flood fill cannot reach). The shell holds the nodes |phi| < 1.5 voxels with inward normal, area weight
/// delta_e(phi) |grad phi| h^3 and material.
/// @pre mesh closed, oriented, free of self-intersections; coordinates in mm.
/// Materials: the first claim that covers a node wins; gaps between claims, up to 8 voxels, go to their neighbours, and
/// `options.material` is for the rest. Labels reach over all of the shell.
/// Parallel on all cores; the result does not depend on their number. Cancelled: nothing is left.
Expected<Anatomy> voxelize(const Mesh& solid, const VoxelizeOptions& options, const Progress& progress = {},
                           std::span<const MaterialClaim> claims = {});

/// The same at the voxel size of a region, and only in the bricks of the region: no more memory is used than its box
/// needs. Near its border too the field is the distance to the object's surface, not to where the region ends. Fails
/// with kEmpty when the region does not meet the object's surface. `options.voxel_mm` is not used.
Expected<Anatomy> voxelizeRegion(const Mesh& solid, const FineRegion& region, const VoxelizeOptions& options,
                                 const Progress& progress = {}, std::span<const MaterialClaim> claims = {});

/// The bare library call on the same mesh with the same bands, for the benchmark's ratio. Returns seconds.
Expected<double> timeBareMeshToVolume(const Mesh& solid, const VoxelizeOptions& options);

}  // namespace kerf
