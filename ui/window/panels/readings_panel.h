// The readings of a cut: depth, distances, force, heat, removed volume; and the 1 kHz loop.
#pragma once

#include "ui/window/frame/panel.h"

namespace kerf {

void drawReadings(PanelFrame& frame);
/// The 1 kHz loop: rate, duration, overruns.
void drawLoop(PanelFrame& frame);

}  // namespace kerf
