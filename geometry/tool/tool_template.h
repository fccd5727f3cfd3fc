// A tool file to start from: every key of a head shape, explained, with numbers that make a tool.
#pragma once

#include <string>

#include "geometry/tool/head_shape.h"

namespace kerf {

/// TOML that readTool accepts as it is. Optional keys are there as comments.
/// @param id  the stem of the file it goes into.
std::string toolTemplate(const HeadShape& shape, const std::string& id);

}  // namespace kerf
