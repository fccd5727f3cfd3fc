// Test helpers: fields sampled from formulas, and the checks of every extracted surface.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

#include "geometry/field/brick_field.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Samples `distance` at all nodes within `reach` voxels of the box, in a field of background 4 voxels.
inline BrickField sampled(double h, const Box3& box, const std::function<double(const Vec3d&)>& distance) {
  const float band = static_cast<float>(4 * h);
  BrickField field(h, band);
  const Vec3i low = ((box.min / h).array().floor().cast<int>() - 8).matrix();
  const Vec3i high = ((box.max / h).array().ceil().cast<int>() + 8).matrix();
  const Vec3i b0 = brickOf(low), b1 = brickOf(high);
  for (int x = b0[0]; x <= b1[0]; ++x)
    for (int y = b0[1]; y <= b1[1]; ++y)
      for (int z = b0[2]; z <= b1[2]; ++z) {
        BrickValues& v = field.brick(field.touch({x, y, z}));
        for (int i = 0; i < 8; ++i)
          for (int j = 0; j < 8; ++j)
            for (int k = 0; k < 8; ++k)
              v[static_cast<std::size_t>(nodeOffset(i, j, k))] = static_cast<float>(
                  std::clamp(distance(h * Vec3d(8 * x + i, 8 * y + j, 8 * z + k)), -double{band}, double{band}));
      }
  return field;
}

inline void expectClosedManifold(const Mesh& m) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const Triangle& t : m.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, n] : uses) {
    EXPECT_EQ(n, 1);
    EXPECT_TRUE(uses.contains({edge.second, edge.first}));
    if (::testing::Test::HasFailure()) return;
  }
}

}  // namespace kerf
