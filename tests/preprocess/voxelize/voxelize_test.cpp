#include "preprocess/voxelize/voxelize.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/global_control.h>

#include <random>

#include "geometry/field/vdb_io.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/temporary_folder.h"

namespace kerf::voxelize_test {
namespace {

constexpr double kPi = std::numbers::pi;
double ballVolume(double r) { return 4.0 / 3 * kPi * r * r * r; }

TEST(Voxelize, FieldIsTheSignedDistanceInTheBand) {
  const TemporaryFolder folder;
  const double r = 3;
  VoxelizeOptions options;
  const auto anatomy = voxelize(ballMesh({0.03, -0.02, 0.01}, r, 160), options);
  ASSERT_TRUE(anatomy) << anatomy.error().message();
  ASSERT_TRUE(anatomy->write(folder.path() / "a.vdb"));
  const auto phi = readVdb(folder.path() / "a.vdb", "phi");
  ASSERT_TRUE(phi) << phi.error().message();
  EXPECT_DOUBLE_EQ(phi->voxel(), 0.1);
  EXPECT_FLOAT_EQ(phi->background(), 0.3f);
  EXPECT_FLOAT_EQ(phi->interior(), -0.4f);
  EXPECT_EQ(phi->at({0, 0, 0}), -0.4f) << "deep inside";
  EXPECT_EQ(phi->at({100, 0, 0}), 0.3f) << "far outside";
  for (int i = 26; i <= 33; ++i) {
    const double exact = (Vec3d(0.1 * i, 0, 0) - Vec3d(0.03, -0.02, 0.01)).norm() - r;
    if (exact > -0.39 && exact < 0.29) {
      EXPECT_NEAR(phi->at({i, 0, 0}), exact, 0.002);
    }
  }
}

TEST(Voxelize, ShellAreaIsTheBallsWithinATwoThousandthsOverTenOffsets) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  for (int n = 0; n < 10; ++n) {
    const Vec3d c = 0.1 * Vec3d(shift(random), shift(random), shift(random));
    const auto anatomy = voxelize(ballMesh(c, 2, 120), {});
    ASSERT_TRUE(anatomy) << anatomy.error().message();
    EXPECT_NEAR(anatomy->stats().shell_area_mm2 / (4 * kPi * 4), 1.0, 0.002);
    // The step counts the outside of a curved surface a little more than its inside: 0.06 % at a radius of 20 voxels.
    EXPECT_NEAR(anatomy->stats().volume_mm3 / ballVolume(2), 1.0, 0.0015);
  }
}

TEST(Voxelize, ShellNormalsAreUnitAndInwardAndEveryPointHasItsMaterial) {
  const TemporaryFolder folder;
  VoxelizeOptions options;
  options.material = Material::kDentin;
  const auto anatomy = voxelize(ballMesh(Vec3d::Zero(), 2, 80), options);
  ASSERT_TRUE(anatomy && anatomy->write(folder.path() / "a.vdb"));
  openvdb::initialize();
  openvdb::io::File file((folder.path() / "a.vdb").string());
  file.open();
  const auto shell = openvdb::gridPtrCast<openvdb::points::PointDataGrid>(file.readGrid("shell"));
  const auto material = openvdb::gridPtrCast<openvdb::Int32Grid>(file.readGrid("material"));
  ASSERT_TRUE(shell && material);

  std::uint64_t points = 0;
  double area = 0;
  for (auto leaf = shell->tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::points::AttributeHandle<openvdb::Vec3f,
                                           openvdb::points::FixedPointCodec<false, openvdb::points::PositionRange>>
        position(leaf->constAttributeArray("P"));
    const openvdb::points::AttributeHandle<openvdb::Vec3f, openvdb::points::UnitVecCodec> normal(
        leaf->constAttributeArray("N"));
    const openvdb::points::AttributeHandle<float> weight(leaf->constAttributeArray("area"));
    const openvdb::points::AttributeHandle<std::int32_t> label(leaf->constAttributeArray("material"));

    for (auto index = leaf->beginIndexOn(); index; ++index) {
      const openvdb::Vec3d p = shell->transform().indexToWorld(position.get(*index) + index.getCoord().asVec3d());
      const openvdb::Vec3d n = normal.get(*index);
      EXPECT_NEAR(n.length(), 1, 1e-3);
      EXPECT_LT(n.dot(p) / p.length(), -0.99) << "inward";
      EXPECT_LT(std::abs(p.length() - 2), 0.151);
      EXPECT_EQ(label.get(*index), static_cast<int>(Material::kDentin));
      area += static_cast<double>(weight.get(*index));
      ++points;
      if (HasFailure()) return;
    }
  }

  EXPECT_EQ(points, anatomy->stats().shell_points);
  EXPECT_NEAR(area, anatomy->stats().shell_area_mm2, 1e-3);
  EXPECT_EQ(material->tree().getValue({0, 0, 0}), static_cast<int>(Material::kDentin));
  EXPECT_EQ(material->tree().getValue({60, 0, 0}), 0);
}

TEST(Voxelize, VoidsAndSolidsInVoidsAreKept) {
  Mesh nested = ballMesh(Vec3d::Zero(), 4, 60);
  append(nested, ballMesh({0.5, 0, 0}, 2.5, 60, true));
  append(nested, ballMesh({0.5, 0, 0}, 1.2, 60));
  append(nested, ballMesh({12, 0, 0}, 1.5, 60));
  const auto anatomy = voxelize(nested, {});
  ASSERT_TRUE(anatomy) << anatomy.error().message();
  const double exact = ballVolume(4) - ballVolume(2.5) + ballVolume(1.2) + ballVolume(1.5);
  EXPECT_NEAR(anatomy->stats().volume_mm3 / exact, 1.0, 0.004);
}

TEST(Voxelize, SameBitsOnOneThreadAndOnAll) {
  const TemporaryFolder folder;
  const auto hash = [&](const char* name) {
    const auto anatomy = voxelize(ballMesh({0.1, 0.2, 0.3}, 2.5, 60), {});
    EXPECT_TRUE(anatomy && anatomy->write(folder.path() / name));
    const auto phi = readVdb(folder.path() / name, "phi");
    EXPECT_TRUE(phi);
    return phi->stateHash();
  };
  const auto all = hash("all.vdb");
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(hash("one.vdb"), all);
}

TEST(Voxelize, VoxelThatCanNotFitIsRefusedWithOneThatWould) {
  VoxelizeOptions options;
  options.voxel_mm = 0.005;
  const Mesh ball = ballMesh(Vec3d::Zero(), 30, 40);
  const auto anatomy = voxelize(ball, options);
  ASSERT_FALSE(anatomy);
  EXPECT_NE(anatomy.error().hint.find("--voxel"), std::string::npos);
  options.voxel_mm = std::stod(anatomy.error().hint.substr(anatomy.error().hint.find("--voxel") + 8));
  EXPECT_LE(estimateBakeBytes(ball, options), options.max_bytes);
  options.voxel_mm = -1;
  EXPECT_FALSE(voxelize(ballMesh(Vec3d::Zero(), 3, 20), options));
}

TEST(Voxelize, CancelledAtAnyStepIsAnError) {
  for (int stop = 0; stop < 4; ++stop) {
    int calls = 0;
    const auto anatomy =
        voxelize(ballMesh(Vec3d::Zero(), 2, 30), {}, [&](double, std::string_view) { return calls++ < stop; });
    ASSERT_FALSE(anatomy);
    EXPECT_EQ(anatomy.error().code, Error::Code::kCancelled);
  }
}

}  // namespace
}  // namespace kerf::voxelize_test
