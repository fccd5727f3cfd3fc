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
/// @param tool_file  a tool's TOML file.
/// @param path_file  CSV of poses or TOML of strokes: docs/reference/path-files.md.
///
/// Errors name the file; a tool that never meets the object is an error too (kEmpty): most often a wrong frame or unit.
Expected<RunManifest> cutCase(const std::filesystem::path& case_folder, const std::filesystem::path& tool_file,
                              const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                              const CutOptions& options = {}, const Progress& progress = {});

}  // namespace kerf
