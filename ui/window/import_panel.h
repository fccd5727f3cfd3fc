// The import panel: what was found in a scan or a label volume, what can be done about it, and what that will give; of
// several files, which one is cut and which stand beside it. It shows an ImportSet and changes its choices; it holds
// nothing else.
#pragma once

#include "ui/app/app_commands.h"
#include "ui/app/camera.h"

namespace kerf {

/// What the window remembers between two frames.
struct ImportPanelState {
  bool shows_solid = true;   ///< the closed solid as soon as it is there; else the scan as it was read
  bool shows_guides = true;  ///< box with its sizes, occlusal plane, level of the base
};

/// Width that the panel takes from the right edge of the window, window units; of type size 1, and as it is.
inline constexpr float kImportPanelWidth = 400;
float importPanelWidth();

/// Draws it while bench.importSet() is there.
void drawImportPanel(AppContext& context, ImportPanelState& state);

/// Box, occlusal plane and base over the picture.   @param pixels  of the framebuffer in a window unit.
void drawImportGuides(const AppContext& context, double pixels);

/// The scan in the part of the window that the panel leaves free, seen from its occlusal side, tilted so that the base
/// is seen as well.
void viewScan(AppContext& context, double pixels);

}  // namespace kerf
