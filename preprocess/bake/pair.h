// Bakes two jaws in one common frame, so that they still meet after loading.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "preprocess/bake/bake.h"

namespace kerf {

/// NAME-STEM.case for either mesh, STEM being its file name without extension; drops a ".case" at the end of `name`.
/// Errors: kBadValue if both meshes have the same stem.
Expected<std::array<std::filesystem::path, 2>> pairFolders(const std::array<std::filesystem::path, 2>& meshes,
                                                           const std::string& name);

/// Bakes two scans of one patient into two cases that name each other and their common frame in the manifest. Moves
/// nothing: coordinates are the files', in mm. Both must have one unit, from any source (kBadValue, before any write).
/// With CloseOptions::find_occlusal_plane both bases are parallel to one plane, the mean of the two found, unless these
/// disagree by more than 15 degrees. BakeReport::pair_check warns of this, of boxes more than 15 mm apart, and of
/// arches that overlap by more than half their height. If the second bake fails, bakePair() removes the first case,
/// unless it replaced an older one.
Expected<std::array<BakeReport, 2>> bakePair(const std::array<std::filesystem::path, 2>& meshes,
                                             const std::array<std::filesystem::path, 2>& case_folders,
                                             const BakeOptions& options, const Progress& progress = {});

}  // namespace kerf
