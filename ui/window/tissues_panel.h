// The list of tissues with their colours, what is seen of each, and the legend of a map of depth or distance.
#pragma once

#include "ui/app/app_commands.h"

namespace kerf {

/// For what has more than one tissue, or while a map is shown.
/// @return  its lower edge; `top` if it is not shown.   @param top  window units.
float drawTissues(AppContext& context, float top);

}  // namespace kerf
