// Picture of a tool in a row of the rack: its cutting part from the side, with the adjoining rest.
#pragma once

#include <array>
#include <vector>

namespace kerf {

struct Tool;

/// In a square of side 1, y downwards; not clipped to it.
struct IconTriangle {
  std::array<std::array<float, 2>, 3> corners{};
  float shade = 1;  ///< 0 to 1
  bool is_cutting = false;
};

/// The triangles that face the viewer, farthest first. Shows the wide side of a blade.   @cost  some ms.
std::vector<IconTriangle> toolIcon(const Tool& tool);

}  // namespace kerf
