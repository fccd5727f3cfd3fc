// Shared by the sources of blade motions: keys, drawings and meshes of toothed blades.
#pragma once

#include <string>

#include "geometry/base/toml_reader.h"
#include "geometry/tool/blade_motion.h"
#include "geometry/tool/drawing_sheet.h"
#include "geometry/tool/tool.h"

namespace kerf::internal {

/// width, length and tooth_pitch, common to all blades with a row of teeth.
void readToothedBlade(TomlTable& top, Tool& tool);
/// edge_depth, default 0.5 mm.
void readEdgeDepth(TomlTable& top, Tool& tool);

/// Depth of a gullet in drawings, mm.
double gulletDepth(const Tool& tool);
/// The cross-section ten times as large beside the drawing (thickness, kerf), and the sheet's head lines.
/// @param numbers  of the second line: "stroke 3 mm".
std::string finishedBladeSheet(Sheet& sheet, const Tool& tool, const std::string& numbers);

}  // namespace kerf::internal
