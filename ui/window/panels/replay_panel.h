// The panels of a replay: a scrub bar with steps below, force and removed volume at the right.
#pragma once

#include "ui/window/frame/panel.h"

namespace kerf {

/// Force and removed volume of the shown moment.
void drawReplayMoment(PanelFrame& frame);
/// The scrub bar.
void drawReplayStrip(AppContext& context);

}  // namespace kerf
