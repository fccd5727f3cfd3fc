#include "sim/live/tissue_section.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "geometry/field/sample_field.h"

namespace kerf::tissue_section_test {
namespace {

constexpr double kVoxel = 0.1;
constexpr Rgba8 kWhite = {240, 240, 240, 255}, kRed = {200, 60, 70, 255};

MaterialProperties row(Material material, const Rgba8& color) {
  MaterialProperties made;
  made.material = material;
  made.color = color;
  return made;
}
const TissuePalette kPalette(MaterialTable({row(Material::kEnamel, kWhite), row(Material::kPulp, kRed)}));

/// A ball of enamel of 2 mm radius with pulp within 1 mm of its middle. Outside there is no label.
class Ball {
 public:
  Ball() : phi0_(sampleDistance([](const Vec3d& p) { return p.norm() - 2; }, {{-2, -2, -2}, {2, 2, 2}}, kVoxel)) {
    for (int x = -4; x < 4; ++x)
      for (int y = -4; y < 4; ++y)
        for (int z = -4; z < 4; ++z)
          for (int n = 0; n < kBrickNodes; ++n) {
            const double r = kVoxel * Vec3d(8 * x + (n >> 6), 8 * y + (n >> 3 & 7), 8 * z + (n & 7)).norm();
            const Material material = r < 1 ? Material::kPulp : r < 2 ? Material::kEnamel : Material::kNone;
            bricks_[{x, y, z}][static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(material);
          }
  }
  TissueLabels labels() const {
    const auto brick = [this](const Vec3i& at) -> const std::uint8_t* {
      const auto found = bricks_.find({at[0], at[1], at[2]});
      return found == bricks_.end() ? nullptr : found->second.data();
    };
    return {.brick = brick, .baked = &phi0_, .fallback = Material::kGeneric};
  }

 private:
  BrickField phi0_;
  std::map<std::array<int, 3>, std::array<std::uint8_t, kBrickNodes>> bricks_;
};

/// Calls check(place, colour, its alpha from 0 to 1) for all points.
template <class Check>
void forEach(const TissueSection& section, const Check& check) {
  for (int j = 0; j < section.height; ++j)
    for (int i = 0; i < section.width; ++i) {
      const Rgba8& c = section.colours[static_cast<std::size_t>(j) * static_cast<std::size_t>(section.width) +
                                       static_cast<std::size_t>(i)];
      const double alpha = c[3] / 255.0;
      check(Vec3d(section.origin + i * section.u + j * section.v),
            Vec3d(c[0] / std::max(alpha, 1e-3), c[1] / std::max(alpha, 1e-3), c[2] / std::max(alpha, 1e-3)), alpha);
    }
}

TEST(TissueSection, HasTheColourOfTheTissueAtEachPlace) {
  const Ball ball;
  for (const Vec3d& normal : {Vec3d(0, 0, 1), Vec3d(1, 2, 3), Vec3d(-1, 0.2, 0)}) {
    const Plane plane{{0.1, -0.2, 0.3}, normal.normalized()};
    const TissueSection section = tissueSection(plane, ball.labels(), kPalette);
    ASSERT_FALSE(section.isEmpty());
    EXPECT_NEAR(section.u.norm(), kVoxel, 1e-12);
    EXPECT_NEAR(section.u.dot(section.v), 0, 1e-12);
    int red = 0, white = 0;
    forEach(section, [&](const Vec3d& p, const Vec3d& colour, double alpha) {
      EXPECT_NEAR(plane.height(p), 0, 1e-9);
      const double r = p.norm(), soft = 1.8 * kVoxel;  // the diagonal of a voxel
      if (r < 1 - soft) {
        EXPECT_EQ(alpha, 1);
        EXPECT_NEAR((colour - Vec3d(200, 60, 70)).norm(), 0, 2);
        ++red;
      } else if (r > 1 + soft && r < 2 - soft) {
        EXPECT_EQ(alpha, 1);
        EXPECT_NEAR((colour - Vec3d(240, 240, 240)).norm(), 0, 2);
        ++white;
      } else if (r > 2 + soft) {
        EXPECT_EQ(alpha, 0);
      } else if (r > 2 - soft && alpha > 0.1) {
        EXPECT_NEAR((colour - Vec3d(240, 240, 240)).norm(), 0, 30) << "no dark rim";
      }
    });
    EXPECT_GT(red, 100);
    EXPECT_GT(white, 300);
  }
}

TEST(TissueSection, APlaneBesideTheObjectIsEmptyAndALargeOneIsCoarser) {
  const Ball ball;
  EXPECT_TRUE(tissueSection({{0, 0, 9}, Vec3d::UnitZ()}, ball.labels(), kPalette).isEmpty());
  EXPECT_TRUE(tissueSection({{0, 0, std::nan("")}, Vec3d::UnitZ()}, ball.labels(), kPalette).isEmpty());
  const TissueSection coarse = tissueSection({{0, 0, 0}, Vec3d::UnitZ()}, ball.labels(), kPalette, 400);
  EXPECT_GT(coarse.u.norm(), 1.5 * kVoxel);
  EXPECT_LT(coarse.colours.size(), 500u);
  EXPECT_EQ(coarse.colours.size(), static_cast<std::size_t>(coarse.width * coarse.height));
}

}  // namespace
}  // namespace kerf::tissue_section_test
