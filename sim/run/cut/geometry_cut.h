// Cuts a case along a path without force: the tool removes the volume swept by its cutting part.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/run/files/run_manifest.h"

namespace kerf {

struct CutOptions {
  bool overwrite = false;
};

/// Cuts a case along a path in lockstep, geometry only, and writes the run. A cut within the case's fine region uses
/// the fine grid, any other cut the object's grid.
/// @param case_or_run  an ended run is continued: the new run contains both cuts.
///   After a geometry-only run its tools and paths are kept and swept again. The result equals one cut along all
///   paths, to the bit. After a run against resistance the field is kept, as in cutCaseByHand(): the cut applies to
///   its pieces where they were put and to its neighbours, and volumes count from the end of that run.
/// @param tool_file  a tool's TOML file.
/// @param path_file  CSV of poses or TOML of strokes: docs/reference/path-files.md.
///
/// Errors name the file. A tool that never meets the object is an error too (kEmpty): most often a wrong frame or unit.
Expected<RunManifest> cutCase(const std::filesystem::path& case_or_run, const std::filesystem::path& tool_file,
                              const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                              const CutOptions& options = {}, const Progress& progress = {});

}  // namespace kerf
