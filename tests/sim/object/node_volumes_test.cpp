// Volumes of nodes, against formulas and meshes.
#include "sim/object/node_volumes.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

#include "bench/scenes/strokes.h"
#include "geometry/field/marching_cubes.h"
#include "tests/sim/block_scene.h"

namespace kerf::node_volumes_test {
namespace {

double sum(const std::array<double, 256>& volumes) { return std::accumulate(volumes.begin(), volumes.end(), 0.0); }

Box3 boxOf(double half) {
  Box3 box;
  box.add(Vec3d::Constant(-half));
  box.add(Vec3d::Constant(half));
  return box;
}

TEST(NodeVolumes, ABallHasItsVolumeWhereverItLies) {
  for (const double radius : {0.5, 1.0})
    for (const double offset : {0.0, 0.031, 0.077}) {
      const Vec3d center(offset, -0.4 * offset, 1.7 * offset);
      const auto ball =
          test::bakedFrom([&](const Vec3d& p) { return (p - center).norm() - radius; }, boxOf(radius + 0.3), 0.1);
      // Chords fall short of the arc by a share of (h / radius)^2.
      const double wanted = 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
      EXPECT_NEAR(sum(ball->volumes()) / wanted, 1, 0.12 * std::pow(0.1 / radius, 2)) << radius << " " << offset;
    }
}

TEST(NodeVolumes, AWallAlongTheGridIsAsThickAsItIsWhateverTheScaleOfItsField) {
  // 3 mm wide with edges at nodes across; `thick` along each axis.
  for (const double scale : {1.0, 0.2})
    for (int axis = 0; axis < 3; ++axis)
      for (const double thick : {0.53, 0.6, 0.671}) {
        const auto wall = test::bakedFrom(
            [&](const Vec3d& p) {
              Vec3d half = Vec3d::Constant(1.45);
              half[axis] = 0.5 * thick;
              return scale * (p.cwiseAbs() - half).maxCoeff();
            },
            boxOf(1.5), 0.1);
        // Along an edge of the wall, the nearest axis differs from that of its thickness.
        EXPECT_NEAR(sum(wall->volumes()), 2.9 * 2.9 * thick, 0.01 * 2.9 * 2.9 * thick) << scale << axis << thick;
      }
}

// Tissues with an oblique border, and a deepening cut through both.
TEST(NodeVolumes, ACutGivesNoTissueMore) {
  const Vec3f top = Vec3f(0.3f, -0.2f, 1).normalized(), border = Vec3f(-0.4f, 0.25f, 1).normalized();
  static constexpr float kVoxel = 0.1f, kBand = 0.4f;
  std::array<std::uint8_t, kBrickNodes> numbers;
  const auto nodeAt = [](std::size_t n) {
    return Vec3f(kVoxel * Vec3f(static_cast<float>(n >> 6), static_cast<float>(n >> 3 & 7), static_cast<float>(n & 7)));
  };
  for (std::size_t n = 0; n < kBrickNodes; ++n) numbers[n] = border.dot(nodeAt(n)) < 0.35f ? 2 : 1;
  const std::uint8_t* const all = numbers.data();

  BrickValues air;
  air.fill(kBand);
  PartsByNumber before{};
  for (float height = 0.75f; height > -0.3f; height -= 0.003f) {
    BrickValues values;
    for (std::size_t n = 0; n < kBrickNodes; ++n) values[n] = std::clamp(top.dot(nodeAt(n)) - height, -kBand, kBand);
    const float *const here = values.data(), *const out = air.data();
    PartsByNumber parts{};
    addVolumes({here, {here, here, here, here, here, out}}, {all, {all, all, all, all, all, all}, false}, kBand, parts);
    for (const std::size_t tissue : {1u, 2u})
      if (height < 0.75f) {
        EXPECT_LE(parts[tissue], before[tissue]) << tissue << " at " << height;
      }
    before = parts;
  }
}

TEST(NodeVolumes, AWholeCellCountsForTheMaterialOfItsNode) {
  BrickValues inside;
  inside.fill(-1);
  std::array<std::uint8_t, kBrickNodes> numbers;
  PartsByNumber wanted{}, sum{};
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    numbers[n] = static_cast<std::uint8_t>(n < 100 ? 200 : n * n % 7);
    wanted[numbers[n]] += kCellParts;
  }
  const float* const values = inside.data();
  const std::uint8_t* const all = numbers.data();
  addVolumes({values, {values, values, values, values, values, values}}, {all, {all, all, all, all, all, all}, false},
             1, sum);
  EXPECT_EQ(sum, wanted);
}

// Between two cuts, phi is small and positive: no surface, no volume.
TEST(NodeVolumes, AFilmBetweenCutsIsNothing) {
  BrickValues film;
  film.fill(1e-6f);
  std::array<std::uint8_t, kBrickNodes> numbers;
  numbers.fill(3);
  const BrickNeighborhood bricks{film.data(),
                                 {film.data(), film.data(), film.data(), film.data(), film.data(), film.data()}};
  const MaterialNeighborhood materials{numbers.data(), {}, true};
  PartsByNumber parts{};
  addVolumes(bricks, materials, 0.3f, parts);
  EXPECT_EQ(parts, PartsByNumber{});

  film[100] = -1e-6f;
  addVolumes(bricks, materials, 0.3f, parts);
  EXPECT_EQ(parts[3], kCellParts) << "one node of this depth among its likes: half an edge to each side";
}

TEST(NodeVolumes, RandomStrokesLeaveTheVolumeOfTheMesh) {
  for (const bool geometry_only : {true, false}) {
    scenes::RandomStrokes strokes;
    strokes.geometry_only = geometry_only;
    const auto ledger = scenes::cutAtRandom(strokes);
    ASSERT_TRUE(ledger) << ledger.error().message();
    EXPECT_GT(ledger->removed, 0.3 * ledger->loaded);
    EXPECT_LT(std::abs(ledger->errorPercent()), 1) << geometry_only;
    EXPECT_LT(ledger->imbalance(), 1e-12) << geometry_only;
  }
}

TEST(NodeVolumes, AFillingFullyCutLeavesNothing) {
  for (const bool geometry_only : {true, false}) {
    const auto filling = scenes::cutFilling(geometry_only);
    ASSERT_TRUE(filling) << filling.error().message();
    EXPECT_GT(filling->added, 0.5);
    EXPECT_EQ(filling->removed, filling->added) << geometry_only;
    EXPECT_EQ(filling->left, 0) << geometry_only;
  }
}

}  // namespace
}  // namespace kerf::node_volumes_test
