#include "preprocess/pair.h"

#include <gtest/gtest.h>

#include "geometry/mesh_writer.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/geometry/temporary_folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

BakeOptions coarse() {
  BakeOptions options;
  options.voxelize.voxel_mm = 0.3;
  return options;
}

TEST(Pair, SharesOneFrameAndNothingMoves) {
  const TemporaryFolder folder;
  const std::array<fs::path, 2> meshes{folder.path() / "upper.ply", folder.path() / "lower.ply"};
  ASSERT_TRUE(writeMesh(meshes[0], ballMesh({40, 2, 13}, 10, 20)));
  ASSERT_TRUE(writeMesh(meshes[1], ballMesh({40, 2, -7}, 10, 20)));
  const auto folders = pairFolders(meshes, (folder.path() / "patient.case").string());
  ASSERT_TRUE(folders);
  EXPECT_EQ((*folders)[0].filename(), "patient-upper.case");
  const auto reports = bakePair(meshes, *folders, coarse());
  ASSERT_TRUE(reports) << reports.error().message();
  const auto upper = readCaseManifest((*folders)[0]), lower = readCaseManifest((*folders)[1]);
  ASSERT_TRUE(upper && lower);
  ASSERT_TRUE(upper->pair && lower->pair);
  EXPECT_EQ(upper->pair->frame, lower->pair->frame);
  EXPECT_EQ(upper->pair->partner, "patient-lower.case");
  EXPECT_EQ(lower->pair->partner, "patient-upper.case");
  EXPECT_NE(upper->id, lower->id);
  EXPECT_NEAR(upper->box.min.z() - lower->box.max.z(), 0, 0.5);  // they still meet
  EXPECT_NEAR(upper->box.center().x(), 40, 0.2);
}

TEST(Pair, JawsInDifferentUnitsAreRefusedAndNothingIsWritten) {
  const TemporaryFolder folder;
  const std::array<fs::path, 2> meshes{folder.path() / "upper.stl", folder.path() / "lower.stl"};
  ASSERT_TRUE(writeMesh(meshes[0], ballMesh({0, 0, 0}, 30, 20)));
  ASSERT_TRUE(writeMesh(meshes[1], ballMesh({0, 0, 0}, 0.03, 20)));  // in metres
  const auto folders = pairFolders(meshes, (folder.path() / "patient").string());
  const auto reports = bakePair(meshes, *folders, coarse());
  ASSERT_FALSE(reports);
  EXPECT_EQ(reports.error().expected, "one unit for both jaws of a pair");
  EXPECT_FALSE(fs::exists((*folders)[0]) || fs::exists((*folders)[1]));
}

TEST(Pair, AFailingPartnerTakesTheFirstCaseWithIt) {
  const TemporaryFolder folder;
  const std::array<fs::path, 2> meshes{folder.path() / "upper.ply", folder.path() / "lower.ply"};
  Mesh bowl = ballMesh({0, 0, 0}, 10, 20);
  std::erase_if(bowl.triangles, [&](const Triangle& f) { return bowl.vertices[f[0]].z() < 0; });
  ASSERT_TRUE(writeMesh(meshes[0], ballMesh({0, 0, 0}, 10, 20)));
  ASSERT_TRUE(writeMesh(meshes[1], bowl));
  const auto folders = pairFolders(meshes, (folder.path() / "patient").string());
  BakeOptions options = coarse();
  options.close.mode = CloseMode::kRepair;  // refuses a missing underside
  ASSERT_FALSE(bakePair(meshes, *folders, options));
  EXPECT_FALSE(fs::exists((*folders)[0]) || fs::exists((*folders)[1]));
}

TEST(Pair, CasesOfOneNameAreRefused) {
  const auto folders = pairFolders({"a/scan.ply", "b/scan.stl"}, "patient");
  ASSERT_FALSE(folders);
  EXPECT_EQ(folders.error().code, Error::Code::kBadValue);
}

}  // namespace
}  // namespace kerf
