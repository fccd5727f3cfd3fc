// Cutting a case along a path without force: the tool removes whatever its cutting part sweeps.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/run/run_manifest.h"

namespace kerf {

struct CutOptions {
  bool overwrite = false;
};

/// Cuts a case along a path in lockstep, geometry only, and writes the run.
/// A cut that stays within the case's fine region is computed on the fine grid, any other one on the object's.
/// @param case_or_run  a run that has ended is gone on from: the new one has all that was cut in both.
///   Of one cut by geometry alone tools and paths are kept, all of them are swept again, and the result is that of one
///   cut along all paths, to the bit. Of one cut against resistance the field is kept, as of cutCaseByHand(): its
///   pieces are cut where they were put, what stood beside it is cut, too, and volumes count from where it ended.
/// @param tool_file  a tool's TOML file.
/// @param path_file  CSV of poses or TOML of strokes: docs/reference/path-files.md.
///
/// Errors name the file; a tool that never meets the object is an error too (kEmpty): most often a wrong frame or unit.
Expected<RunManifest> cutCase(const std::filesystem::path& case_or_run, const std::filesystem::path& tool_file,
                              const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                              const CutOptions& options = {}, const Progress& progress = {});

}  // namespace kerf
