// Search paths of the program's data: tools, materials, paths.
#pragma once

#include <filesystem>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// Folder of the program, or of the shared library that Kerf is linked into: that of a Python module. Empty: unknown.
std::filesystem::path ownFolder();

/// Every existing place of `name` ("tools", "materials.toml"), by preference: in $KERF_ASSETS, beside the program
/// (build tree, then installed), in the install folder, in the source tree of the build. Without repetition.
std::vector<std::filesystem::path> findAssets(const std::filesystem::path& name);

/// Error kBadValue: $KERF_ASSETS is set, and names no folder that holds tools/, paths/ or materials.toml. Programs call
/// this once at start: with a misspelt path the user would silently get Kerf's tools and materials.
Expected<void> requireAssets();

}  // namespace kerf
