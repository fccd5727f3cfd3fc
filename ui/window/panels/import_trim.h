// Cutting parts of a scan away in the import: the controls in its panel, and the line over the picture.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

class ImportPlan;

/// The group "Cut away" of the import panel.
void drawTrims(AppContext& context, const ImportPlan& plan);

/// The line being drawn, and a hint.   @param pixels  of the framebuffer in a window unit.
void drawTrimLine(const AppContext& context, double pixels);

}  // namespace kerf
