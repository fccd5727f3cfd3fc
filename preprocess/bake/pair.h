// Two jaws that share one frame: baked side by side, so that they still meet when they are loaded.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "preprocess/bake/bake.h"

namespace kerf {

/// NAME-STEM.case for either mesh, STEM being its file name without extension; a ".case" at the end of `name` is left
/// out. Errors: kBadValue if both meshes have the same stem.
Expected<std::array<std::filesystem::path, 2>> pairFolders(const std::array<std::filesystem::path, 2>& meshes,
                                                           const std::string& name);

/// Bakes two scans of one patient into two cases that name each other and their common frame in the manifest. Nothing
/// is moved: coordinates are the files', in mm. Both must be in one unit, however it was found (kBadValue, before
/// anything is written). With CloseOptions::find_occlusal_plane both bases are parallel to one plane, the mean of the
/// two found, unless these disagree by more than 15 degrees. That, boxes more than 15 mm apart, and arches that lie in
/// each other by more than half their height are warned of in BakeReport::pair_check. If the second bake fails, the
/// first case is removed again, unless it replaced an older one.
Expected<std::array<BakeReport, 2>> bakePair(const std::array<std::filesystem::path, 2>& meshes,
                                             const std::array<std::filesystem::path, 2>& case_folders,
                                             const BakeOptions& options, const Progress& progress = {});

}  // namespace kerf
