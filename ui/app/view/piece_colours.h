// User colours of pieces, to distinguish them in the picture.
//
// Okabe & Ito, "Color universal design", 2008: seven hues, distinct with and without red and green cones.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

struct PieceColour {
  const char* name;  ///< in the command and in files: "sky"
  Rgba8 colour;      ///< sRGB
};
std::span<const PieceColour> pieceColours();
/// Null: no such name.
const PieceColour* findPieceColour(std::string_view name);

/// Shifts vertex colours to another hue. Keeps light and shade of tissues, a third of their own colour, and the gloss.
void tint(std::vector<Rgba8>& colours, const PieceColour& of);

}  // namespace kerf
