// The picture of a tool in a row of the rack: what cuts, from the side, with as much of the rest as is beside it.
#pragma once

#include <array>
#include <vector>

namespace kerf {

struct Tool;

/// In a square of side 1, y downwards; what reaches out of it is not cut off.
struct IconTriangle {
  std::array<std::array<float, 2>, 3> corners{};
  float shade = 1;  ///< 0 to 1
  bool is_cutting = false;
};

/// The triangles that face the viewer, the farthest first. A blade is seen on its wide side.   @cost  some ms.
std::vector<IconTriangle> toolIcon(const Tool& tool);

}  // namespace kerf
