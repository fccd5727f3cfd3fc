#include "preprocess/print/surface_map.h"

#include "geometry/mesh/map_colour.h"
#include "tests/preprocess/print/print_shapes.h"

namespace kerf {
namespace {

TEST(SurfaceMap, AreasOverALimitAreThoseOfALinearFunction) {
  // The value is the height in a box 2 x 3 x 4: of the walls a quarter lies above 3, and the top.
  const Mesh mesh = box(Vec3d::Zero(), Vec3d(2, 3, 4));
  std::vector<double> values;
  for (const Vec3d& p : mesh.vertices) values.push_back(p[2]);
  const SurfaceNumbers n = surfaceNumbers(mesh, values, 3);
  EXPECT_NEAR(n.over_mm2, 10 * 1 + 6, 1e-12);
  EXPECT_NEAR(n.under_mm2, 10 * 3 + 6, 1e-12);
  EXPECT_EQ(n.least_mm, 0);
  EXPECT_EQ(n.most_mm, 4);
  EXPECT_EQ(n.least_at, Vec3d::Zero());
  EXPECT_EQ(n.most_at, Vec3d(0, 0, 4));
  EXPECT_NEAR(surfaceNumbers(mesh, values, 0).over_mm2, 46, 1e-12);
  EXPECT_EQ(surfaceNumbers(mesh, values, 4).over_mm2, 0);
  EXPECT_EQ(surfaceNumbers({}, {}, 1).most_mm, 0);
}

TEST(SurfaceMap, ColoursRunFromLightToDarkInEitherDirection) {
  const MapRange thickness{3, 1};
  EXPECT_EQ(thickness.colour(5), mapColour(0));
  EXPECT_EQ(thickness.colour(2), mapColour(0.5));
  EXPECT_EQ(thickness.colour(0.2), mapColour(1));
  const auto rows = legendTable(thickness, 5);
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[1].mm, 2.5);
  const std::vector<double> values{3, 2.5, 1};
  EXPECT_EQ(mapColours(values, thickness), (std::vector<Rgba8>{rows[0].colour, rows[1].colour, rows[4].colour}));
}

}  // namespace
}  // namespace kerf
