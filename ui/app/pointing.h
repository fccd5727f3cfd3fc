// Pixels and rays: what a pointer in the picture points at.
#pragma once

#include <array>
#include <optional>

#include "ui/app/app_commands.h"

namespace kerf {

/// Under the pixel that two words name, the first of them word `n`.   Error kBadValue.
Expected<Ray> rayOf(const AppContext& context, AppWords words, std::size_t n = 0);
/// Through the pixel that the words name, or else through the cursor.   Error kBadValue: neither is there.
Expected<Ray> pointedRay(const AppContext& context, AppWords words);
/// The ray under a pixel (y downwards) of the picture. It begins 300 mm before the focus; in perspective no nearer to
/// the eye than what is shown. Rays of one camera begin in one plane, square to the view.
Ray rayUnder(const Camera& camera, double x, double y, int width, int height);
/// The way back: where a point of the world is in the picture; of one behind the eye, far outside.
std::array<double, 2> pixelOf(const Camera& camera, const Vec3d& point, int width, int height);
/// What is seen at a pixel; nothing: the background, or a scan that is only being imported.
std::optional<Vec3d> pointUnder(AppContext& context, double x, double y);
/// As orbit(), about a point: it stays where it is in the picture, and as near.
void orbitAbout(Camera& camera, const Vec3d& pivot, double dx, double dy);
/// Makes things larger by a factor about a pixel. In perspective the surface there comes into focus first: what was
/// under the cursor stays there, and the eye does not come through it.
void zoomAt(AppContext& context, double x, double y, double factor);
/// The box in view, with some margin.
void fitToBox(Camera& camera, const Box3& box, int width, int height);

}  // namespace kerf
