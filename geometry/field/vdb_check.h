// Whether OpenVDB may be given a file: it trusts every length in it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "geometry/base/error.h"

namespace kerf::internal {

/// Walks the whole structure of one grid, without its values: the file's header and metadata, the index of grids, the
/// transform, each node's masks and each block's length. OpenVDB allocates what these say before it looks; after this
/// it allocates at most 40 times the size of the file, and reads nothing past an end.
/// @param type  "Tree_float_5_4_3" or "Tree_int32_5_4_3", stored as it is, not as half floats.
/// @return an error that names the grid, the byte, and what was found there.
/// @cost reads the file once: 0.2 s a GB where it lies in memory.
Expected<void> checkVdbGrid(const std::filesystem::path& path, const std::string& name, std::string_view type);

}  // namespace kerf::internal
