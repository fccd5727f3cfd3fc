// The finer grids of a region against a whole object baked at that resolution: equal within the region.
#include "geometry/field/fine_region.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointDataGrid.h>

#include <map>

#include "preprocess/voxelize/voxelize.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/temporary_folder.h"

namespace kerf::fine_region_test {
namespace {

TEST(FineRegion, DepthIsTheDistanceToItsBorder) {
  const FineRegion bent{{{0, 0, 0}, {10, 0, 0}, {10, 10, 0}}, 2, 0.1};
  EXPECT_DOUBLE_EQ(bent.depth({5, 0, 0}), 2);
  EXPECT_DOUBLE_EQ(bent.depth({5, 0, 3}), -1);
  EXPECT_DOUBLE_EQ(bent.depth({12, 5, 0}), 0);
  EXPECT_DOUBLE_EQ(bent.depth({-3, 4, 0}), -3);
  EXPECT_EQ(bent.bounds().min, Vec3d(-2, -2, -2));
  EXPECT_EQ(bent.bounds().max, Vec3d(12, 12, 2));
  const FineRegion ball{{{1, 2, 3}}, 0.5, 0.1};
  EXPECT_DOUBLE_EQ(ball.depth({1, 2, 4}), -0.5);
}

TEST(FineRegion, MeetsEveryBrickThatHoldsAPointOfIt) {
  const FineRegion region{{{0.3, 0.2, -4}, {3, 1, 5}}, 0.7, 0.05};
  for (int x = -40; x <= 160; ++x)
    for (int y = -30; y <= 40; ++y)
      for (int z = -150; z <= 150; z += 3)
        if (region.depth(0.05 * Vec3d(x, y, z)) >= 0) {
          ASSERT_TRUE(region.mayMeetBrick(brickOf({x, y, z})));
        }
  EXPECT_FALSE(region.mayMeetBrick({20, 20, 20}));
}

TEST(FineRegion, ThinningKeepsEndsAndSpacing) {
  std::vector<Vec3d> line;
  for (int n = 0; n <= 1000; ++n) line.emplace_back(0.01 * n, 0, 0);
  const auto thin = thinned(line, 0.25);
  EXPECT_EQ(thin.front(), line.front());
  EXPECT_EQ(thin.back(), line.back());
  EXPECT_LE(thin.size(), 42u);
  for (std::size_t n = 2; n < thin.size(); ++n) EXPECT_GE((thin[n - 1] - thin[n - 2]).norm(), 0.25);
  EXPECT_EQ(thinned({{1, 1, 1}, {1, 1, 1}}, 0.1).size(), 1u);
}

struct ShellPoint {
  openvdb::Vec3f normal;
  float area;
  int material;
};

struct Grids {
  openvdb::FloatGrid::Ptr phi;
  openvdb::Int32Grid::Ptr material;
  std::map<openvdb::Coord, ShellPoint> shell;
};

Grids gridsOf(const std::filesystem::path& file_name, const std::string& suffix) {
  openvdb::initialize();
  openvdb::io::File file(file_name.string());
  file.open();
  Grids out{openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("phi" + suffix)),
            openvdb::gridPtrCast<openvdb::Int32Grid>(file.readGrid("material" + suffix)),
            {}};
  const auto shell = openvdb::gridPtrCast<openvdb::points::PointDataGrid>(file.readGrid("shell" + suffix));
  for (auto leaf = shell->tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::points::AttributeHandle<openvdb::Vec3f, openvdb::points::UnitVecCodec> normal(
        leaf->constAttributeArray("N"));
    const openvdb::points::AttributeHandle<float> area(leaf->constAttributeArray("area"));
    const openvdb::points::AttributeHandle<std::int32_t> material(leaf->constAttributeArray("material"));
    for (auto index = leaf->beginIndexOn(); index; ++index)
      out.shell[index.getCoord()] = {normal.get(*index), area.get(*index), material.get(*index)};
  }
  return out;
}

/// A tooth with a pulp and a layer of enamel, and a region over its side and into the pulp.
struct Tooth {
  Mesh tooth = ballMesh({0.03, 0.02, 0.01}, 3, 120), pulp = ballMesh({0.53, 0.02, 0.04}, 1.2, 80);
  std::vector<MaterialClaim> claims;
  FineRegion region{{{0.5, 0, 0.2}, {1.5, 0.4, 0.5}, {3.2, 0.5, 1}}, 0.8, 0.05};
  Tooth() {
    MaterialClaim enamel, inner, dentin;
    enamel.material = Material::kEnamel;
    enamel.depth = DepthRule{0.6, Plane{{0, 0, 0}, Vec3d::UnitZ()}};
    inner.material = Material::kPulp;
    inner.solid = &pulp;
    dentin.material = Material::kDentin;
    dentin.solid = &tooth;
    claims = {inner, enamel, dentin};
  }
};

TEST(FineRegion, HoldsWhatAnObjectBakedThatFineHoldsThere) {
  const TemporaryFolder folder;
  const Tooth t;
  VoxelizeOptions fine;
  fine.voxel_mm = 0.05;
  const auto whole = voxelize(t.tooth, fine, {}, t.claims);
  const auto coarse = voxelize(t.tooth, {}, {}, t.claims);
  const auto region = voxelizeRegion(t.tooth, t.region, {}, {}, t.claims);
  ASSERT_TRUE(whole && coarse);
  ASSERT_TRUE(region) << region.error().message();
  ASSERT_TRUE(whole->write(folder.path() / "whole.vdb"));
  ASSERT_TRUE(coarse->write(folder.path() / "both.vdb", &*region));
  const Grids expected = gridsOf(folder.path() / "whole.vdb", ""), found = gridsOf(folder.path() / "both.vdb", "_fine");
  EXPECT_EQ(gridsOf(folder.path() / "both.vdb", "").phi->voxelSize()[0], 0.1);
  EXPECT_EQ(found.phi->voxelSize()[0], 0.05);

  std::size_t inside = 0, surface = 0, outside = 0;
  std::map<int, std::size_t> materials;
  for (int x = -70; x <= 90; ++x)
    for (int y = -70; y <= 70; ++y)
      for (int z = -70; z <= 70; ++z) {
        const openvdb::Coord c(x, y, z);
        const Vec3d p = 0.05 * Vec3d(x, y, z);
        if (!t.region.mayMeetBrick(brickOf({x, y, z}))) {
          ASSERT_EQ(found.phi->tree().getValue(c), found.phi->background());
          ASSERT_EQ(found.shell.count(c), 0u);
          continue;
        }
        ASSERT_EQ(found.phi->tree().getValue(c), expected.phi->tree().getValue(c)) << p.transpose();
        const int material = expected.material->tree().getValue(c);
        ASSERT_EQ(found.material->tree().getValue(c), material) << p.transpose();
        const auto e = expected.shell.find(c), f = found.shell.find(c);
        ASSERT_EQ(e == expected.shell.end(), f == found.shell.end()) << p.transpose();
        if (f != found.shell.end()) {
          ++surface;
          ASSERT_EQ(e->second.area, f->second.area);
          ASSERT_EQ(e->second.normal, f->second.normal);
          ASSERT_EQ(e->second.material, f->second.material);
        }
        ++(expected.phi->tree().getValue(c) < 0 ? inside : outside);
        ++materials[material];
      }

  EXPECT_GT(surface, 1000u) << "a test that compares nothing would pass";
  EXPECT_GT(inside, 10000u);
  EXPECT_GT(outside, 5000u);
  for (const Material m : {Material::kEnamel, Material::kDentin, Material::kPulp})
    EXPECT_GT(materials[static_cast<int>(m)], 1000u) << static_cast<int>(m);
  EXPECT_EQ(region->stats().shell_points, found.shell.size());
  EXPECT_EQ(region->stats().active_voxels, found.phi->activeVoxelCount());
}

TEST(FineRegion, WithoutSurfaceInItIsRefused) {
  const Tooth t;
  for (const Vec3d& at : {Vec3d(20, 0, 0), Vec3d(-1.5, 0, 0)}) {  // beside the object; deep inside it
    const auto none = voxelizeRegion(t.tooth, FineRegion{{at}, 0.5, 0.05}, {}, {}, t.claims);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, Error::Code::kEmpty);
    EXPECT_NE(none.error().message().find("fine region"), std::string::npos) << none.error().message();
  }
}

TEST(FineRegion, OfATinyVoxelIsRefusedBeforeMemoryIsTaken) {
  const Tooth t;
  VoxelizeOptions little;
  little.max_bytes = 20 << 20;
  const auto refused = voxelizeRegion(t.tooth, FineRegion{t.region.line, 0.8, 0.006}, little, {}, t.claims);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("--fine-voxel"), std::string::npos) << refused.error().message();
}

}  // namespace
}  // namespace kerf::fine_region_test
