// A block as a mesh, with or without its underside, which scans lack.
#pragma once

#include "geometry/mesh/mesh.h"

namespace kerf::test {

/// Its top at z = 0. Default size: 6 x 4 x 3 mm.
inline Mesh blockMesh(bool has_underside, const Vec3d& size = {6, 4, 3}) {
  Mesh block;
  for (int n = 0; n < 8; ++n)
    block.vertices.push_back({(n & 1 ? 0.5 : -0.5) * size[0], (n & 2 ? 0.5 : -0.5) * size[1], n & 4 ? 0.0 : -size[2]});
  block.triangles = {{4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4}, {2, 6, 3},
                     {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  if (!has_underside) return block;
  block.triangles.push_back({0, 2, 1});
  block.triangles.push_back({1, 2, 3});
  return block;
}

}  // namespace kerf::test
