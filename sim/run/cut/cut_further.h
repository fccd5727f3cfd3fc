// A geometry-only cut that continues a run cut against resistance.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/run/cut/geometry_cut.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_manifest.h"

namespace kerf::internal {

/// The earlier run has a field but no sweep, so the new run has none either: run.vdb and begin.vdb are as for a cut
/// against resistance. The sweep cuts the case, its pieces where they were put, and its neighbours.
/// @param run  has ended.   Errors: as cutCase().
Expected<RunManifest> cutFurther(const std::filesystem::path& run, const std::filesystem::path& tool_file,
                                 const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                                 const CutOptions& options, const Progress& progress);

/// Writes summary.json of a geometry-only cut.   @param initial  mm^3 by material, as loaded.
Expected<void> writeGeometrySummary(const std::filesystem::path& file, const std::map<std::string, double>& initial,
                                    const std::map<std::string, double>& removed, const PieceCount& left);

}  // namespace kerf::internal
