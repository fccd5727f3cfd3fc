#include "geometry/mesh/map_colour.h"

#include <algorithm>

namespace kerf {
namespace {

// Even steps of L* in CIELAB, 92 to 20, from yellow to blue: no step relies on red against green.
constexpr std::array<std::array<double, 3>, 9> kMap = {{{253, 232, 147},
                                                        {224, 207, 138},
                                                        {196, 182, 130},
                                                        {168, 158, 124},
                                                        {141, 134, 119},
                                                        {114, 110, 115},
                                                        {85, 88, 113},
                                                        {52, 66, 112},
                                                        {0, 47, 111}}};

}  // namespace

Rgba8 mapColour(double share) {
  const double at = std::clamp(std::isfinite(share) ? share : 1.0, 0.0, 1.0) * (kMap.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(at), kMap.size() - 2);
  const double t = at - static_cast<double>(low);
  Rgba8 out{0, 0, 0, 255};
  for (std::size_t k = 0; k < 3; ++k)
    out[k] = static_cast<std::uint8_t>(std::lround((1 - t) * kMap[low][k] + t * kMap[low + 1][k]));
  return out;
}

}  // namespace kerf
