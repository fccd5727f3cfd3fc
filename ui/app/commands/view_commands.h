// The first view of a document. The commands view.* are in view_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// First view of a newly opened document: `otherwise`, with the occlusal side up if there is one. From above looks
/// perpendicular to that side.
void firstView(AppContext& context, const Camera& otherwise);
/// First view of the scan in the import: its occlusal side, tilted to show the base too.
void viewScan(AppContext& context);

}  // namespace kerf
