// What a tool file may say, and hardly means.
#pragma once

#include <string>

#include "geometry/tool/tool.h"

namespace kerf::cli {

/// A sentence about a tool that is allowed and unusual: a mesh that is longest across the axis about which it turns, a
/// head ten times too wide. Empty for most. @cost O(triangles) of a tool that is a mesh.
std::string doubtAbout(const Tool& tool);

}  // namespace kerf::cli
