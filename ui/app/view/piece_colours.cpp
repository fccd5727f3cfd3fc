#include "ui/app/view/piece_colours.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {

constexpr std::array<PieceColour, 7> kColours = {{{"orange", {230, 159, 0, 255}},
                                                  {"sky", {86, 180, 233, 255}},
                                                  {"green", {0, 158, 115, 255}},
                                                  {"yellow", {240, 228, 66, 255}},
                                                  {"blue", {0, 114, 178, 255}},
                                                  {"vermilion", {213, 94, 0, 255}},
                                                  {"purple", {204, 121, 167, 255}}}};
constexpr double kShare = 0.67;  // of the hue
constexpr double kLight = 225;   // lightness of a tissue that shows the hue as in the table

}  // namespace

std::span<const PieceColour> pieceColours() { return kColours; }

const PieceColour* findPieceColour(std::string_view name) {
  const auto at = std::find_if(kColours.begin(), kColours.end(), [&](const PieceColour& c) { return c.name == name; });
  return at == kColours.end() ? nullptr : &*at;
}

void tint(std::vector<Rgba8>& colours, const PieceColour& of) {
  for (Rgba8& colour : colours) {
    const double light = std::min(1.1, 0.25 * (colour[0] + 2 * colour[1] + colour[2]) / kLight);
    for (std::size_t k = 0; k < 3; ++k) {
      const double mixed = (1 - kShare) * colour[k] + kShare * light * of.colour[k];
      colour[k] = static_cast<std::uint8_t>(std::lround(std::clamp(mixed, 0.0, 255.0)));
    }
  }
}

}  // namespace kerf
