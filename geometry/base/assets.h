// Search paths of the program's data: tools, materials, paths.
#pragma once

#include <filesystem>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// Folder of the program, or of the shared library that Kerf is linked into: that of a Python module. Empty: unknown.
std::filesystem::path ownFolder();

/// The prefix of the installation: the last one given to setInstalledPrefix(), else that of the build's configuration.
std::filesystem::path installedPrefix();
/// For a program outside the prefix that has Kerf's static libraries in it: library/kerf.h calls this with the prefix
/// that CMake's find_package(kerf) found. Before main(): not thread-safe.
void setInstalledPrefix(const std::filesystem::path& prefix);

/// Every existing place of `name` ("tools", "materials.toml"), by preference: in $KERF_ASSETS, in share/kerf of each
/// folder above the program (build/PRESET, where CMake links it to assets/, and a prefix), in the installed prefix.
/// Without repetition.
std::vector<std::filesystem::path> findAssets(const std::filesystem::path& name);

/// Error kBadValue: $KERF_ASSETS is set, and names no folder that holds tools/, paths/ or materials.toml. Programs call
/// this once at start: with a misspelt path the user would silently get Kerf's tools and materials.
Expected<void> requireAssets();

}  // namespace kerf
