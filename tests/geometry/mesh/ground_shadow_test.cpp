#include "geometry/mesh/ground_shadow.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/geometry/ball_mesh.h"

namespace kerf::ground_shadow_test {
namespace {

float darknessAt(const GroundShadow& shadow, double x, double y) {
  const double cell = shadow.side / GroundShadow::kCells;
  const auto column = static_cast<std::size_t>((x - shadow.center[0]) / cell + 0.5 * GroundShadow::kCells);
  const auto row = static_cast<std::size_t>((y - shadow.center[1]) / cell + 0.5 * GroundShadow::kCells);
  return shadow.darkness[row * GroundShadow::kCells + column];
}

TEST(GroundShadow, IsDarkestUnderWhatStandsThereAndEndsWithinItsSquare) {
  const Vec3d center(30, -20, 7);
  const GroundShadow shadow = groundShadow(ballMesh(center, 3, 24));
  EXPECT_NEAR(shadow.center[2], 4, 1e-5) << "the plane is that of the lowest point";

  const float under = darknessAt(shadow, center[0], center[1]);
  EXPECT_GT(under, 0.1f);
  EXPECT_GT(under, 2 * darknessAt(shadow, center[0] + 2.8, center[1]));
  for (const float d : shadow.darkness) {
    EXPECT_GE(d, 0);
    EXPECT_LE(d, 1);
  }
  constexpr std::size_t kN = GroundShadow::kCells;
  for (std::size_t n = 0; n < kN; ++n)
    for (const std::size_t rim : {n, (kN - 1) * kN + n, n * kN, n * kN + kN - 1})
      EXPECT_EQ(shadow.darkness[rim], 0) << "no edge is seen where the map ends";
}

TEST(GroundShadow, OfWhatIsHighAboveTheGroundIsPaler) {
  Mesh mesh = ballMesh({0, 0, 2}, 2, 24);
  append(mesh, ballMesh({12, 0, 20}, 2, 24));
  const GroundShadow shadow = groundShadow(mesh);
  EXPECT_GT(darknessAt(shadow, 0, 0), 3 * darknessAt(shadow, 12, 0));
}

TEST(GroundShadow, OfNothingIsNone) {
  const GroundShadow shadow = groundShadow({});
  EXPECT_EQ(std::accumulate(shadow.darkness.begin(), shadow.darkness.end(), 0.0f), 0);
}

}  // namespace
}  // namespace kerf::ground_shadow_test
