// Valid but unlikely values of a tool file.
#pragma once

#include <string>

#include "geometry/tool/tool.h"

namespace kerf {

/// Remarks about a valid but unusual tool, separated by "; ": a mesh longest across its rotation axis or in another
/// unit, a head ten times too wide or half or twice as wide as its name says, a shank for no handpiece. Empty for most.
/// @cost O(triangles) of a mesh tool.
std::string doubtAbout(const Tool& tool);

/// "mm_per_unit = 25.4 (inches) makes it 19 mm long": the units in which a mesh is as long as a bur, 10 to 60 mm. Empty
/// if none.   @param length  in the unit of its file.
std::string unitsOfABur(double length);

/// Largest angle between the length of a mesh and its axis, degrees.
inline constexpr double kMostDegreesOff = 3;

}  // namespace kerf
