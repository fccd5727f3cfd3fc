#include "sim/live/tissue_colours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "bench/scenes/carved_field.h"
#include "bench/scenes/practice_block.h"
#include "geometry/field/sample_field.h"

namespace kerf::tissue_colours_test {
namespace {

constexpr double kVoxel = 0.1;
constexpr Rgba8 kWhite = {240, 240, 240, 255}, kYellow = {230, 200, 120, 255}, kRed = {200, 60, 70, 255};

MaterialProperties row(Material material, const Rgba8& color) {
  MaterialProperties made;
  made.material = material;
  made.color = color;
  return made;
}
const TissuePalette kPalette(MaterialTable({row(Material::kEnamel, kWhite), row(Material::kDentin, kYellow),
                                            row(Material::kPulp, kRed)}));

/// A block of 6 x 6 x 4 mm, its top at z = 0, with the material of each place from `material`.
class Block {
 public:
  explicit Block(const std::function<Material(const Vec3d&)>& material)
      : phi0_(sampleDistance(
            [](const Vec3d& p) {
              const Vec3d q = (p - Vec3d(0, 0, -2)).cwiseAbs() - Vec3d(3, 3, 2);
              return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
            },
            {{-3, -3, -4}, {3, 3, 0}}, kVoxel)),
        remesher_(phi0_, {.marching_cubes = {}, .is_parallel = false}) {
    for (int x = -5; x <= 5; ++x)
      for (int y = -5; y <= 5; ++y)
        for (int z = -7; z <= 1; ++z) {
          auto& numbers = bricks_[{x, y, z}];
          for (int n = 0; n < kBrickNodes; ++n) {
            const Vec3i node(8 * x + (n >> 6), 8 * y + (n >> 3 & 7), 8 * z + (n & 7));
            const bool is_inside = phi0_.at(node) < 0;
            numbers[static_cast<std::size_t>(n)] =
                is_inside ? static_cast<std::uint8_t>(material(kVoxel * node.cast<double>())) : std::uint8_t{0};
          }
        }
  }
  TissueLabels labels() const {
    const auto brick = [this](const Vec3i& at) -> const std::uint8_t* {
      const auto found = bricks_.find({at[0], at[1], at[2]});
      return found == bricks_.end() ? nullptr : found->second.data();
    };
    return {.brick = brick, .baked = &phi0_, .fallback = Material::kGeneric};
  }
  void carve(const Vec3d& center, double radius) {
    OverlayField field(phi0_);
    remesher_.apply(scenes::carve(field, center, radius));
  }
  /// Calls check(position, normal, colour) for all vertices.
  template <class Check>
  void forEach(const Check& check) const {
    for (const MeshChunkPtr& chunk : remesher_.changedSince(0)) {
      const std::vector<Rgba8> colours = tissueColours(*chunk, labels(), kPalette);
      ASSERT_EQ(colours.size(), chunk->vertices.size());
      EXPECT_EQ(colours, tissueColours(*chunk, labels(), kPalette));
      for (std::size_t v = 0; v < colours.size(); ++v)
        check(Vec3d(chunk->vertices[v].cast<double>()), Vec3d(chunk->normals[v].cast<double>()), colours[v]);
    }
  }

 private:
  BrickField phi0_;
  Remesher remesher_;
  std::map<std::array<int, 3>, std::array<std::uint8_t, kBrickNodes>> bricks_;
};

bool isNear(const Rgba8& a, const Rgba8& b, int most = 2) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(int{a[k]} - int{b[k]}) > most) return false;
  return true;
}

TEST(TissueColours, AreThoseOfTheTable) {
  Block([](const Vec3d&) { return Material::kDentin; }).forEach([](const Vec3d&, const Vec3d&, const Rgba8& colour) {
    EXPECT_TRUE(isNear(colour, kYellow));
  });
}

TEST(TissueColours, TurnIntoEachOtherOverTwoVoxelsAndNotInStairs) {
  int between = 0;
  // A slanting border on the top side. Stairs would show as pure colours on the wrong side.
  const auto side = [](const Vec3d& p) { return p[0] - 0.37 * p[1] - 0.013; };
  Block([&](const Vec3d& p) {
    return side(p) < 0 ? Material::kDentin : Material::kPulp;
  }).forEach([&](const Vec3d& p, const Vec3d& n, const Rgba8& colour) {
    if (n[2] < 0.99) return;
    const double distance = side(p) / std::hypot(1, 0.37);
    if (distance < -2.2 * kVoxel) {
      EXPECT_TRUE(isNear(colour, kYellow)) << p.transpose();
    }
    if (distance > 2.2 * kVoxel) {
      EXPECT_TRUE(isNear(colour, kRed)) << p.transpose();
    }
    between += !isNear(colour, kYellow, 8) && !isNear(colour, kRed, 8);
  });
  EXPECT_GT(between, 30);
}

TEST(TissueColours, EnamelIsWarmerWhereItIsThin) {
  // On the top 0.3 mm thick at x < 0, 2 mm at x > 0.
  const Block block(
      [](const Vec3d& p) { return p[2] > (p[0] < 0 ? -0.3 : -2) ? Material::kEnamel : Material::kDentin; });
  block.forEach([](const Vec3d& p, const Vec3d& n, const Rgba8& colour) {
    if (n[2] < 0.99 || std::abs(p[0]) < 0.3) return;
    const int warmth = colour[0] - colour[2];
    if (p[0] < 0) {
      EXPECT_GT(warmth, 25);
      EXPECT_LT(warmth, 105);
    } else {
      EXPECT_LT(warmth, 15);
    }
  });
}

TEST(TissueColours, ACutFaceHasTheColourOfItsTissueAShadeDarkerAndIsMatte) {
  Block block([](const Vec3d& p) { return p[2] > -0.8 ? Material::kEnamel : Material::kDentin; });
  block.carve({0, 0, 0}, 1.5);
  int enamel = 0, dentin = 0;
  block.forEach([&](const Vec3d& p, const Vec3d& n, const Rgba8& colour) {
    const auto shade = [](const Rgba8& c) {
      Rgba8 made = c;
      for (std::size_t k = 0; k < 3; ++k) made[k] = static_cast<std::uint8_t>(std::lround(0.92 * c[k]));
      return made;
    };
    if (p.norm() > 1.6 && n[2] > 0.99) {
      EXPECT_GT(colour[3], 200);
    }  // sound enamel is glossy
    if (std::abs(p.norm() - 1.5) > 0.05 || p[2] > -0.3) return;
    EXPECT_LT(colour[3], 100);
    if (p[2] > -0.6) enamel += isNear(colour, shade(kWhite), 3);
    if (p[2] < -1.0) dentin += isNear(colour, shade(kYellow), 3);
  });
  EXPECT_GT(enamel, 50);
  EXPECT_GT(dentin, 50);
}

TEST(TissueColours, WithoutLabelsTheObjectHasTheColourOfItsFallback) {
  Block([](const Vec3d&) { return Material::kNone; }).forEach([](const Vec3d&, const Vec3d&, const Rgba8& colour) {
    EXPECT_TRUE(isNear(colour, MaterialProperties{}.color));
  });
}

TEST(TissueColours, OfALoadedObjectAreThoseOfItsMaterial) {
  const auto block = practiceBlock({4, 4, 2}, 0.2, {}, Material::kPulp);
  ASSERT_TRUE(block);
  const Remesher remesher((*block)->phi0(), {.marching_cubes = {}, .is_parallel = false});
  for (const MeshChunkPtr& chunk : remesher.changedSince(0))
    for (const Rgba8& colour : tissueColours(*chunk, TissueLabels::of(**block), kPalette))
      EXPECT_TRUE(isNear(colour, kRed));
}

}  // namespace
}  // namespace kerf::tissue_colours_test
