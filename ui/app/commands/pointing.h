// Pixels and rays: the scene point under a pointer in the picture.
#pragma once

#include <array>
#include <optional>

#include "ui/app/commands/app_commands.h"
#include "ui/app/view/live_surface.h"

namespace kerf {

/// Ray under the pixel given by two words, from word `n`.   Error kBadValue.
Expected<Ray> rayOf(const AppContext& context, AppWords words, std::size_t n = 0);
/// Ray through the pixel given by the words, else through the cursor.   Error kBadValue: neither is there.
Expected<Ray> pointedRay(const AppContext& context, AppWords words);
/// The ray under a pixel (y downwards) of the picture. It begins 300 mm before the focus; in perspective no nearer to
/// the eye than the near plane. Rays of one camera begin in one plane, perpendicular to the view.
Ray rayUnder(const Camera& camera, double x, double y, int width, int height);
/// The inverse: the picture position of a world point; far outside for a point behind the eye.
std::array<double, 2> pixelOf(const Camera& camera, const Vec3d& point, int width, int height);
/// Visible point at a pixel. None: the background, or a scan still in import.
std::optional<Vec3d> pointUnder(AppContext& context, double x, double y);

}  // namespace kerf
