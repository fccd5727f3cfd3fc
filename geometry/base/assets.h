// Where the program finds its data: tools, materials, paths.
#pragma once

#include <filesystem>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// Every existing place of `name` ("tools", "materials.toml"), the first to be preferred: in $KERF_ASSETS, beside the
/// program (build tree, then installed), where Kerf was installed, in the source tree it was built from. Without
/// repetition.
std::vector<std::filesystem::path> findAssets(const std::filesystem::path& name);

/// Error kBadValue: $KERF_ASSETS is set, and names no folder that holds tools/, paths/ or materials.toml. Programs ask
/// once when they begin: misspelt, it would leave the user with tools and materials of ours in place of his own.
Expected<void> requireAssets();

}  // namespace kerf
