// The phases of every bake, for any source of the object:
//
//   plan      options, materials, hashes of the inputs        bake.cpp, bake_recipe.cpp; settleSizes()
//   open      the id of the case; does it exist already?      openCase()
//   read      meshes and labels, brought to mm                bake_sources.cpp, bake_recipe.cpp
//   check     defects of the sources, in a thread beside      checkAside()
//   close     one solid, and the material of each place       bake.cpp, bake_recipe.cpp; finishClosing()
//   voxelize  distance field, materials, point shell          voxelizeObject()
//   write     manifest, solid and grids; the case appears     writeCase()
#pragma once

#include <chrono>
#include <filesystem>
#include <future>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/atomic_file.h"
#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/field/material.h"
#include "geometry/mesh/mesh.h"
#include "preprocess/bake/bake.h"
#include "preprocess/voxelize/voxelize.h"

namespace kerf::internal {

class Stopwatch {
 public:
  /// Seconds since the last lap, or since the start.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double s = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return s;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Data passed from phase to phase.
struct BakeJob {
  BakeOptions options;
  const Progress& progress;
  BakeReport report{};
  Stopwatch watch{};
};

/// The object to bake, from any source. The claims may point to meshes and labels that must outlive it.
struct BakeObject {
  Mesh solid;
  std::vector<MaterialClaim> claims;
};

struct BakedGrids {
  Anatomy anatomy;
  std::optional<Anatomy> fine;  ///< grids of BakeOptions::region
};

/// Fills in default sizes. Errors: kBadValue for a voxel size out of range, or in a fine region not below the object's.
Expected<void> settleSizes(BakeOptions& options);

/// Gives the case its id, from all inputs of the result: the same id means the same case.
/// @param hashes  of the inputs.   @param more  further inputs of the result, as text.
/// @return the folder to build the case in, or empty if the same case exists already, undamaged, and
/// `options.overwrite` is not set; the report then states it.
Expected<std::optional<AtomicFolder>> openCase(const std::filesystem::path& case_folder,
                                               std::span<const std::string> hashes, const std::string& more,
                                               BakeJob& job);

using MeshChecks = std::future<std::vector<MeshReport>>;
/// Checks the sources in a separate thread, while closing repairs them; the result is only for the report.
/// The future's destructor waits, so the meshes must outlive it.
MeshChecks checkAside(const std::vector<Mesh>& sources);

/// Records the times of closing and of the parallel checks, and the results of the checks.
void finishClosing(MeshChecks& checks, BakeJob& job);

/// Distance field, materials and point shell, at 0.3 to 0.85 of the job. Fills the region in the manifest.
Expected<BakedGrids> voxelizeObject(const BakeObject& object, const MaterialTable& materials, BakeJob& job);

/// Completes the manifest, writes solid and grids, and lets the case appear in its place.
/// @pre  manifest.parts has an entry per claim.
Expected<void> writeCase(const BakeObject& object, const BakedGrids& grids, const MaterialTable& materials,
                         AtomicFolder& staging, BakeJob& job);

}  // namespace kerf::internal
