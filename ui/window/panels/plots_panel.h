// Plots of the last 20 s: force, torque, spindle, depth, removed volume.
#pragma once

#include "ui/window/frame/panel.h"

namespace kerf {

void drawPlots(PanelFrame& frame);

}  // namespace kerf
