// Colours that a person gives to pieces, so that they are told apart in the picture.
//
// Okabe & Ito, "Color universal design", 2008: seven hues that are told apart with and without red and green cones.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "geometry/base/types.h"

namespace kerf {

struct PieceColour {
  const char* name;  ///< of the command and in files: "sky"
  Rgba8 colour;      ///< sRGB
};
std::span<const PieceColour> pieceColours();
/// Null: there is none of that name.
const PieceColour* findPieceColour(std::string_view name);

/// Colours of vertices in another hue: light and shade of tissues stay, and a third of their own colour. Gloss stays.
void tint(std::vector<Rgba8>& colours, const PieceColour& of);

}  // namespace kerf
