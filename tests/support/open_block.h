// A block as a mesh, with or without its underside: what scans lack.
#pragma once

#include "geometry/mesh/mesh.h"

namespace kerf::test {

/// 6 x 4 x 3 mm, its top at z = 0.
inline Mesh blockMesh(bool has_underside) {
  Mesh block;
  for (int n = 0; n < 8; ++n) block.vertices.push_back({n & 1 ? 3.0 : -3.0, n & 2 ? 2.0 : -2.0, n & 4 ? 0.0 : -3.0});
  block.triangles = {{4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4}, {2, 6, 3},
                     {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  if (!has_underside) return block;
  block.triangles.push_back({0, 2, 1});
  block.triangles.push_back({1, 2, 3});
  return block;
}

}  // namespace kerf::test
