// Outlines of a text in a font, as polygons.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf {

/// Lines of a text relative to each other.
enum class TextAlign { kLeft, kCentre, kRight };

namespace internal {

using Point2d = Eigen::Vector2d;
using Contour = std::vector<Point2d>;  ///< closed; the last point joins the first

/// Largest distance of the polygons from the font's curves, mm.
inline constexpr double kOutlineTolerance = 0.01;

/// Contours of the glyphs, mm; x to the right, y up. They may overlap; a point is in the text if their winding number
/// is not 0. The rectangle around them has its middle at (0, 0). Glyphs stand side by side by their advance and the
/// font's `kern` table; no shaping.
/// @param text  UTF-8; '\n' ends a line. Lines lie 1.6 cap heights apart.
/// @param height_mm  of a capital letter.   @param font  any file that FreeType reads; empty: Inter Bold.
/// Errors: kEmpty: nothing to draw; kBadFormat: not UTF-8; kUnsupported: names the characters that the font lacks;
/// kNotFound: no font, with the package that brings it; kUnreadable.   @cost  1 ms.   @thread any.
Expected<std::vector<Contour>> glyphOutlines(std::string_view text, double height_mm, TextAlign align,
                                             const std::filesystem::path& font = {});

}  // namespace internal
}  // namespace kerf
