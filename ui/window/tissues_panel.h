// The list of tissues with their colours, what is seen of each, and the legend of a map of depth or distance.
#pragma once

#include "ui/window/panel_column.h"

namespace kerf {

/// For what has more than one tissue, or while a map is shown.
void drawTissues(AppContext& context, PanelColumn& column);

}  // namespace kerf
