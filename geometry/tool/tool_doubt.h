// Valid but unlikely values of a tool file.
#pragma once

#include <string>

#include "geometry/tool/tool.h"

namespace kerf {

/// A sentence about a valid but unusual tool: a mesh longest across its rotation axis, a head ten times too wide. Empty
/// for most. @cost O(triangles) of a mesh tool.
std::string doubtAbout(const Tool& tool);

}  // namespace kerf
