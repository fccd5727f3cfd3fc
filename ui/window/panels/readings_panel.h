// The readings of a cut: depth, distances, force, heat, removed volume, the 1 kHz loop; and the sections of other
// panels.
#pragma once

#include "ui/window/frame/panel.h"

namespace kerf {

void drawReadings(PanelFrame& frame);
/// The 1 kHz loop: rate, duration, overruns; a section.
void drawLoop(PanelFrame& frame);
/// The rows of the panel table with PanelPlace::kReadings. Draws within the window of a panel.
void drawSections(PanelFrame& frame);

}  // namespace kerf
