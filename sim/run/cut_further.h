// A cut of geometry alone that goes on from a run cut against resistance.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/run/geometry_cut.h"
#include "sim/run/removed_volumes.h"
#include "sim/run/run_manifest.h"

namespace kerf::internal {

/// Of that run there is a field and no sweep, so the new one has no sweep either: run.vdb and begin.vdb are those of a
/// cut against resistance. What is swept: the case, its pieces where they were put, and what stood beside it.
/// @param run  has ended.   Errors: as cutCase().
Expected<RunManifest> cutFurther(const std::filesystem::path& run, const std::filesystem::path& tool_file,
                                 const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                                 const CutOptions& options, const Progress& progress);

/// summary.json of a cut of geometry alone.   @param initial  mm^3 by material, as it was loaded.
Expected<void> writeGeometrySummary(const std::filesystem::path& file, const std::map<std::string, double>& initial,
                                    const std::map<std::string, double>& removed, const PieceCount& left);

}  // namespace kerf::internal
