// Workshop drawing of a tool: cutting part, inert parts, and dimensions.
#pragma once

#include <string>

#include "geometry/tool/tool.h"

namespace kerf {

/// Side view as SVG, to scale, tip down: outline, cutting part coloured, centre line, dimensions in mm, scale bar,
/// name, ISO 6360. Burs are cut short above 1.6 head lengths or 14 mm of neck and shank (marked by a break line);
/// blades show teeth, and the cross-section with thickness and kerf beside it. Text only: deterministic, needs no
/// fonts.
std::string toolDrawing(const Tool& tool);

}  // namespace kerf
