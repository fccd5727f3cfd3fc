// Zoom, turn and fit of the view about places of the scene.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf {

/// As orbit(), about a point: its picture position and distance stay.
void orbitAbout(Camera& camera, const Vec3d& pivot, double dx, double dy);
/// Magnifies by a factor about a pixel. In perspective it first focuses on the surface there: the point under the
/// cursor stays, and the eye does not pass through it.
void zoomAt(AppContext& context, double x, double y, double factor);
/// Fits the box into the view, with some margin.
void fitToBox(Camera& camera, const Box3& box, int width, int height);
/// The same, into the area that the panels leave free.
void fitToFree(AppContext& context, const Box3& box);

}  // namespace kerf
