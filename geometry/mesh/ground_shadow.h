// Soft shadow of an object on its ground plane, as a small map made once per mesh on the CPU.
#pragma once

#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

/// Darkness in [0, 1] over a square of the plane z = `height`, rows along +y.
struct GroundShadow {
  static constexpr int kCells = 128;
  Vec3d center = Vec3d::Zero();  ///< centre of the square, world frame; z is the plane's height, mm
  double side = 1;               ///< mm
  std::vector<float> darkness = std::vector<float>(kCells * kCells, 0.0f);
};

/// Parts near the plane through the lowest point darken most; blurred over a fortieth and a tenth of the square.
/// All zero for an empty mesh. O(area / cell area + triangles).
GroundShadow groundShadow(const Mesh& mesh);

}  // namespace kerf
