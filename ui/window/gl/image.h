// A picture in memory and its PNG file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/view/picture_grid.h"
#include "ui/app/view/tissue_display.h"

namespace kerf {

/// 8-bit sRGB with straight alpha, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  ///< 4 * width * height

  const std::uint8_t* at(int x, int y) const {
    return rgba.data() +
           4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  std::uint8_t* at(int x, int y) { return const_cast<std::uint8_t*>(static_cast<const Image*>(this)->at(x, y)); }
};

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

/// Reads a PNG of at most 4096 pixels a side. Errors: kNotFound, kBadFormat.
Expected<Image> readPng(const std::filesystem::path& path);

/// Writes a PNG by AtomicFile: replaces an existing file completely or not at all.
Expected<void> writePng(const std::filesystem::path& path, const Image& image);

}  // namespace kerf
