// Checks a file before OpenVDB reads it, because OpenVDB trusts every length in it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "geometry/base/error.h"

namespace kerf::internal {

/// Walks the whole structure of one grid, without its values: the file's header and metadata, the index of grids, the
/// transform, each node's masks and each block's length. OpenVDB allocates by these numbers unchecked. After this check
/// it allocates at most 40 times the size of the file, and reads nothing past an end.
/// @param type  "Tree_float_5_4_3" or "Tree_int32_5_4_3", stored as it is, not as half floats.
/// @return an error that names the grid, the byte, and the found value.
/// @cost reads the file once: 0.2 s a GB from the page cache.
Expected<void> checkVdbGrid(const std::filesystem::path& path, const std::string& name, std::string_view type);

}  // namespace kerf::internal
