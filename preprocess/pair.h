// Two jaws that share one frame: baked side by side, so that they still meet when they are loaded.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "preprocess/bake.h"

namespace kerf {

/// NAME-STEM.case for either mesh, STEM being its file name without extension; a ".case" at the end of `name` is left
/// out. Errors: kBadValue if both meshes have the same stem.
Expected<std::array<std::filesystem::path, 2>> pairFolders(const std::array<std::filesystem::path, 2>& meshes,
                                                           const std::string& name);

/// Bakes two scans of one patient into two cases that name each other and their common frame in the manifest. Nothing
/// is moved: coordinates are the files', in mm. Both must be in one unit, however it was found (kBadValue, before
/// anything is written). If the second bake fails, the first case is removed again, unless it replaced an older one.
Expected<std::array<BakeReport, 2>> bakePair(const std::array<std::filesystem::path, 2>& meshes,
                                             const std::array<std::filesystem::path, 2>& case_folders,
                                             const BakeOptions& options, const Progress& progress = {});

}  // namespace kerf
