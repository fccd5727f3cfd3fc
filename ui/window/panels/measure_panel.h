// Measured points over the picture, and their numbers.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// Draws nothing without points.   @param pixels  of the picture per window unit.
void drawMeasure(AppContext& context, double pixels);

}  // namespace kerf
