// A scale bar in the picture, drawn by Dear ImGui behind all panels.
#pragma once

#include <imgui.h>

#include "ui/app/view/camera.h"

namespace kerf {

/// Its right end is at `at`, in units of the window. In perspective it holds at the depth of the target and says so.
/// @param width, height  of the picture, pixels.   @param pixels_per_unit  of the window's units.
void drawScaleBarAt(const ImVec2& at, const Camera& camera, int width, int height, double pixels_per_unit, ImU32 ink);

}  // namespace kerf
