// Material of a node: claims in order of priority, depths, gaps.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>

#include "geometry/base/hash.h"
#include "geometry/field/material_field.h"
#include "preprocess/voxelize/voxelize.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/temporary_folder.h"

namespace kerf::paint_materials_test {
namespace {

constexpr double kPi = std::numbers::pi;
double ballVolume(double r) { return 4.0 / 3 * kPi * r * r * r; }
/// Volume of the cap of height `height` of a ball of radius r.
double capVolume(double r, double height) { return kPi * height * height * (3 * r - height) / 3; }

MaterialClaim inside(Material material, const Mesh& solid) {
  MaterialClaim claim;
  claim.material = material;
  claim.solid = &solid;
  return claim;
}

struct Labels {
  openvdb::Int32Grid::Ptr material;
  openvdb::points::PointDataGrid::Ptr shell;
};

Labels written(const Anatomy& anatomy, const TemporaryFolder& folder) {
  EXPECT_TRUE(anatomy.write(folder.path() / "a.vdb"));
  openvdb::initialize();
  openvdb::io::File file((folder.path() / "a.vdb").string());
  file.open();
  return {openvdb::gridPtrCast<openvdb::Int32Grid>(file.readGrid("material")),
          openvdb::gridPtrCast<openvdb::points::PointDataGrid>(file.readGrid("shell"))};
}

/// Calls work(position, material) for every point of the shell and returns their number.
template <class Work>
std::size_t forEachShellPoint(const openvdb::points::PointDataGrid& shell, const Work& work) {
  std::size_t count = 0;
  for (auto leaf = shell.tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::points::AttributeHandle<std::int32_t> label(leaf->constAttributeArray("material"));
    for (auto index = leaf->beginIndexOn(); index; ++index, ++count) {
      const openvdb::Vec3d p = shell.transform().indexToWorld(index.getCoord());
      work(Vec3d(p.x(), p.y(), p.z()), static_cast<Material>(label.get(*index)));
    }
  }
  return count;
}

TEST(PaintMaterials, NestedSolidsGetTheirVolumesAndTheFirstWins) {
  const Mesh tooth = ballMesh({0.03, 0.02, 0.01}, 3, 120), pulp = ballMesh({0.53, 0.02, 0.04}, 1.2, 80);
  const std::vector<MaterialClaim> claims{inside(Material::kPulp, pulp), inside(Material::kDentin, tooth)};
  const auto anatomy = voxelize(tooth, {}, {}, claims);
  ASSERT_TRUE(anatomy) << anatomy.error().message();
  const MaterialVolumes& v = anatomy->stats().materials;
  EXPECT_NEAR(v.claimed_mm3[0] / ballVolume(1.2), 1, 0.01);
  EXPECT_NEAR(v.claimed_mm3[1] / (ballVolume(3) - ballVolume(1.2)), 1, 0.01);
  EXPECT_NEAR(v.claimed_mm3[0] + v.claimed_mm3[1], anatomy->stats().volume_mm3, 1e-6) << "nothing lost, nothing twice";
  EXPECT_EQ(v.forgotten_mm3, 0);

  const std::vector<MaterialClaim> other_way{inside(Material::kDentin, tooth), inside(Material::kPulp, pulp)};
  const auto hidden = voxelize(tooth, {}, {}, other_way);
  ASSERT_TRUE(hidden);
  EXPECT_EQ(hidden->stats().materials.claimed_mm3[1], 0) << "the tooth came first and covers it all";
}

TEST(PaintMaterials, ReadBackTheLabelsAreThoseOfTheFile) {
  const TemporaryFolder folder;
  const Mesh tooth = ballMesh({0.03, 0.02, 0.01}, 1.5, 80), pulp = ballMesh({0.53, 0.02, 0.04}, 0.6, 60);
  const std::vector<MaterialClaim> claims{inside(Material::kPulp, pulp), inside(Material::kDentin, tooth)};
  const auto anatomy = voxelize(tooth, {}, {}, claims);
  ASSERT_TRUE(anatomy) << anatomy.error().message();
  const Labels labels = written(*anatomy, folder);
  const auto field = readMaterialField(folder.path() / "a.vdb");
  ASSERT_TRUE(field) << field.error().message();
  EXPECT_DOUBLE_EQ(field->voxel(), 0.1);
  for (int x = -20; x <= 20; ++x)
    for (int y = -20; y <= 20; ++y)
      for (int z = -20; z <= 20; ++z)
        ASSERT_EQ(static_cast<int>(field->at({x, y, z})), labels.material->tree().getValue({x, y, z}));
  int mixed = 0;
  for (int x = -4; x <= 3; ++x)
    for (int y = -4; y <= 3; ++y)
      for (int z = -4; z <= 3; ++z) {
        std::array<std::uint8_t, kBrickNodes> numbers;
        const bool is_one = field->copyBrick({x, y, z}, numbers);
        for (int n = 0; n < kBrickNodes; ++n)
          ASSERT_EQ(int{numbers[static_cast<std::size_t>(n)]},
                    labels.material->tree().getValue({8 * x + (n >> 6), 8 * y + (n >> 3 & 7), 8 * z + (n & 7)}));
        ASSERT_EQ(is_one, std::all_of(numbers.begin(), numbers.end(), [&](auto m) { return m == numbers[0]; }));
        ASSERT_EQ(field->oneOf({x, y, z}), is_one ? std::optional(static_cast<Material>(numbers[0])) : std::nullopt);
        mixed += !is_one;
      }
  EXPECT_GT(mixed, 20);
  EXPECT_EQ(field->near({0.53, 0.02, 0.04}), Material::kPulp);
  EXPECT_EQ(field->near({-1.0, 0, 0}), Material::kDentin);
  EXPECT_EQ(field->near({0, 0, 1.5 + 0.3}), Material::kDentin) << "a little outside: what is nearest";
  EXPECT_EQ(field->near({0, 0, 5}), Material::kNone);
  folder.write("b.vdb", "no such thing");
  EXPECT_FALSE(readMaterialField(folder.path() / "b.vdb"));
}

TEST(PaintMaterials, ADepthAboveAPlaneReplacesOnlyWhatItMay) {
  const double r = 3, depth = 0.6;
  // Off the lattice: a ball of whole voxels about a node has many nodes exactly on its surface.
  const Vec3d c(0.031, 0.017, 0.043);
  const Mesh tooth = ballMesh(c, r, 160), core = ballMesh(c + Vec3d(0, 0, 2.2), 0.5, 60);
  MaterialClaim enamel;
  enamel.material = Material::kEnamel;
  enamel.depth = DepthRule{depth, Plane{c + Vec3d(0, 0, 1), Vec3d::UnitZ()}};
  enamel.replaces = {Material::kDentin};
  const std::vector<MaterialClaim> claims{enamel, inside(Material::kPulp, core), inside(Material::kDentin, tooth)};
  const auto anatomy = voxelize(tooth, {}, {}, claims);
  ASSERT_TRUE(anatomy) << anatomy.error().message();

  const double layer = capVolume(r, r - 1) - capVolume(r - depth, r - depth - 1);
  const double core_in_layer = [] {  // the core reaches up to 2.7, 0.3 into the layer, and stays pulp there
    double sum = 0;
    constexpr int kSteps = 400;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {
        const double z = 1.7 + (i + 0.5) / kSteps, rho = 0.5 * (j + 0.5) / kSteps;
        if (rho * rho + (z - 2.2) * (z - 2.2) < 0.25 && std::hypot(rho, z) > 2.4)
          sum += 2 * kPi * rho * (1.0 / kSteps) * (0.5 / kSteps);
      }
    return sum;
  }();

  EXPECT_NEAR(anatomy->stats().materials.claimed_mm3[0] / (layer - core_in_layer), 1, 0.01);
  EXPECT_NEAR(anatomy->stats().materials.claimed_mm3[1] / ballVolume(0.5), 1, 0.02) << "a ball of five voxels";
}

TEST(PaintMaterials, EveryShellPointHasTheMaterialOfItsPlace) {
  const TemporaryFolder folder;
  const Mesh ball = ballMesh({0.02, 0.01, 0.04}, 2, 100);
  MaterialClaim upper;
  upper.material = Material::kEnamel;
  upper.covers = [](const Vec3d& p) { return p.z() > 0.51; };
  const std::vector<MaterialClaim> claims{upper, inside(Material::kDentin, ball)};
  const auto anatomy = voxelize(ball, {}, {}, claims);
  ASSERT_TRUE(anatomy) << anatomy.error().message();
  const Labels labels = written(*anatomy, folder);
  const std::size_t count = forEachShellPoint(*labels.shell, [](const Vec3d& p, Material m) {
    if (p.z() > 0.51) {
      EXPECT_EQ(m, Material::kEnamel) << p.transpose();
    } else if (p.z() < 0.51 - 0.21) {  // outer half of the shell uses the neighbours: two voxels of doubt
      EXPECT_EQ(m, Material::kDentin) << p.transpose();
    } else {
      EXPECT_TRUE(m == Material::kEnamel || m == Material::kDentin) << p.transpose();
    }
  });
  EXPECT_EQ(count, anatomy->stats().shell_points);
  EXPECT_EQ(labels.material->tree().getValue({0, 0, 15}), static_cast<int>(Material::kEnamel));
  EXPECT_EQ(labels.material->tree().getValue({0, 0, -15}), static_cast<int>(Material::kDentin));
  EXPECT_EQ(labels.material->tree().getValue({0, 0, 40}), 0) << "outside";
}

TEST(PaintMaterials, ANarrowGapGoesToItsNeighboursAndIsReported) {
  const Vec3d c(0.031, 0.017, 0.043);
  const Mesh tooth = ballMesh(c, 3, 120), core = ballMesh(c, 2, 100);
  Mesh rind = ballMesh(c, 3, 120);
  append(rind, ballMesh(c, 2.4, 100, true));
  const std::vector<MaterialClaim> claims{inside(Material::kEnamel, rind), inside(Material::kDentin, core)};
  const auto anatomy = voxelize(tooth, {}, {}, claims);
  ASSERT_TRUE(anatomy) << anatomy.error().message();
  const MaterialVolumes& v = anatomy->stats().materials;
  // The outer half of the shell lies in no claim either: the step puts a little volume there.
  EXPECT_NEAR(v.unclaimed_mm3, ballVolume(2.4) - ballVolume(2), 0.08 * ballVolume(3));
  EXPECT_GT(v.unclaimed_mm3, ballVolume(2.4) - ballVolume(2));
  EXPECT_EQ(v.forgotten_mm3, 0);
  EXPECT_NEAR(v.claimed_mm3[1], ballVolume(2.2), 0.03 * ballVolume(2.2)) << "half of the gap";
}

TEST(PaintMaterials, WhatNoPartIsNearIsForgottenAloud) {
  const Mesh tooth = ballMesh(Vec3d::Zero(), 3, 120), core = ballMesh(Vec3d::Zero(), 1, 80);
  const std::vector<MaterialClaim> claims{inside(Material::kPulp, core)};
  const auto anatomy = voxelize(tooth, {}, {}, claims);
  ASSERT_TRUE(anatomy) << anatomy.error().message();
  const MaterialVolumes& v = anatomy->stats().materials;
  EXPECT_GT(v.forgotten_mm3, 0.5 * ballVolume(3));
  EXPECT_NEAR(v.forgotten_mm3 + v.claimed_mm3[0], anatomy->stats().volume_mm3, 1e-6);
}

TEST(PaintMaterials, SameLabelsOnOneThreadAndOnAll) {
  const TemporaryFolder folder;
  const Mesh tooth = ballMesh(Vec3d::Zero(), 2.5, 100), core = ballMesh({0.3, 0, 0}, 1, 60);
  const std::vector<MaterialClaim> claims{inside(Material::kPulp, core), inside(Material::kDentin, tooth)};
  std::vector<int> values[2];
  for (int run = 0; run < 2; ++run) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, run == 0 ? 1 : 4);
    const auto anatomy = voxelize(tooth, {}, {}, claims);
    ASSERT_TRUE(anatomy);
    const Labels labels = written(*anatomy, folder);
    const openvdb::CoordBBox box = labels.material->evalActiveVoxelBoundingBox();
    for (auto c = box.begin(); c; ++c) values[run].push_back(labels.material->tree().getValue(*c));
  }
  EXPECT_TRUE(values[0] == values[1]);
}

}  // namespace
}  // namespace kerf::paint_materials_test
