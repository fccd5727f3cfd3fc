// The panels of a replay: a scrub bar with steps below, force and removed volume at the right. And the dialog for an
// opened run: continue it, or watch it.
#pragma once

#include "ui/window/frame/panel.h"

namespace kerf {

/// Force and removed volume of the shown moment.
void drawReplayMoment(PanelFrame& frame);
/// The scrub bar.
void drawReplayStrip(AppContext& context);
/// Draws nothing unless the user has opened a run.
void drawRunQuestion(AppContext& context);

}  // namespace kerf
