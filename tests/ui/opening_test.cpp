#include "ui/app/import/opening.h"

#include <gtest/gtest.h>

#include "geometry/formats/mesh_writer.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/view/upright.h"

namespace kerf::opening_test {
namespace {

TEST(KindOf, TellsScanRecipeAndCaseApart) {
  const TemporaryFolder folder;
  const auto scan = folder.path() / "scan.ply";
  ASSERT_TRUE(writeMesh(scan, test::blockMesh(false)));
  EXPECT_EQ(kindOf(scan), FileKind::kScan);
  EXPECT_EQ(kindOf(folder.path() / "nothing.stl"), FileKind::kScan) << "reading it tells what is wrong";
  EXPECT_EQ(kindOf(folder.write("tooth.toml", "[[part]]\nmesh = \"scan.ply\"\n")), FileKind::kRecipe);

  OpeningOptions options;
  options.data_folder = folder.path() / "data";
  const auto opened = openToCut(scan, options);
  EXPECT_FALSE(opened) << "a rack without tools cuts nothing";
  const auto cases = options.data_folder / "cases";
  ASSERT_TRUE(std::filesystem::exists(cases));
  for (const auto& entry : std::filesystem::directory_iterator(cases)) EXPECT_EQ(kindOf(entry.path()), FileKind::kCase);
}

TEST(VoxelFor, GrowsWithTheScan) {
  EXPECT_EQ(voxelFor(100), 0.1);
  EXPECT_GT(voxelFor(5000), 0.1);
  EXPECT_EQ(voxelFor(1e6), 0.25);
}

TEST(OcclusalNormalOf, IsAwayFromTheBaseOfABlock) {
  const auto normal = occlusalNormalOf(test::blockMesh(true));
  ASSERT_TRUE(normal);
  EXPECT_TRUE(*normal == Vec3d::UnitZ()) << normal->transpose();
}

}  // namespace
}  // namespace kerf::opening_test
