// Marks in a picture: the legend of a map, the scale bar, the grid.
#pragma once

#include <string_view>

#include "ui/app/view/picture_grid.h"
#include "ui/app/view/tissue_display.h"
#include "ui/window/gl/image.h"

namespace kerf {

/// Draws a bar of `length_mm` with its length written above it into the lower right corner, dark grey.
/// Sizes follow the height of the picture. The bar is within half a pixel of its true length.
void drawScaleBar(Image& image, double length_mm, double mm_per_pixel);

/// Draws thin lines with their numbers at the upper and the left edge, on small light plates, and names the scan's axes
/// there. The picture shines through the lines. Where numbers at the upper edge would touch, every second, fifth, tenth
/// ... line has one.
/// @pre  grid.step_mm > 0
void drawGrid(Image& image, const PictureGrid& grid);

/// Draws the legend of a map into the lower left corner, on a light plate. A narrower picture gets a part of it.
void drawLegend(Image& image, const MapLegend& legend);
/// Whether the strokes for numbers in pictures have all of these characters.
bool canBeDrawn(std::string_view text);

}  // namespace kerf
