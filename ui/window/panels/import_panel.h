// The import panel: findings in a scan or label volume, their remedies and the result; of several files, which is cut
// and which are neighbours. It shows an ImportSet and changes its choices; it holds no other state.
#pragma once

#include "ui/app/commands/app_commands.h"
#include "ui/app/view/camera.h"
#include "ui/app/workbench/imports.h"

namespace kerf {

/// State of the panel between two frames.
struct ImportPanelState {
  bool shows_solid = true;   ///< the closed solid once it exists; else the scan as read
  bool shows_guides = true;  ///< box with its sizes, occlusal plane, level of the base
};

/// Draws the panel while bench.imports->set() exists.
void drawImportPanel(AppContext& context, ImportPanelState& state);

/// Box, occlusal plane and base over the picture.   @param pixels  of the framebuffer in a window unit.
void drawImportGuides(const AppContext& context, double pixels);

}  // namespace kerf
