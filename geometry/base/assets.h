// Where the program finds its data: tools, materials, paths.
#pragma once

#include <filesystem>
#include <vector>

namespace kerf {

/// Every existing place of `name` ("tools", "materials.toml"), the first to be preferred: in $KERF_ASSETS, beside the
/// program (build tree, then installed), where Kerf was installed, in the source tree it was built from. Without
/// repetition.
std::vector<std::filesystem::path> findAssets(const std::filesystem::path& name);

}  // namespace kerf
