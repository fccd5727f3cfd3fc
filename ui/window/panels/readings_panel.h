// The readings of a cut: depth, distances, force, heat, removed volume, the 1 kHz loop; and the sections of other
// panels.
#pragma once

#include "ui/window/panels/panel.h"

namespace kerf {

void drawReadings(PanelFrame& frame);

}  // namespace kerf
