// The list of tissues with colours and visibility, and the legend of a map of depth or distance.
#pragma once

#include "ui/window/frame/panel_column.h"

namespace kerf {

/// Shown if there is more than one tissue, or while a map is shown.
void drawTissues(AppContext& context, PanelColumn& column);

}  // namespace kerf
