// Grids whose numbers are no distances, in cases and runs whose manifests vouch for them.
#include <gtest/gtest.h>

#include <random>

#include "geometry/base/hash.h"
#include "geometry/case/case_bundle.h"
#include "geometry/field/vdb_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/bake/bake.h"
#include "sim/run/export_bundle.h"
#include "sim/run/geometry_cut.h"
#include "sim/run/haptic_cut.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

BrickField noiseLike(const BrickField& field) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(field.interior(), field.background());
  BrickField out = field;
  for (std::size_t b = 0; b < out.brickCount(); ++b)
    for (float& v : out.brick(b)) v = value(random);
  return out;
}

BrickField turned(const BrickField& field) {
  BrickField out = field;
  for (std::size_t b = 0; b < out.brickCount(); ++b)
    for (float& v : out.brick(b)) v = -v;
  return out;
}

// A block with finer voxels around a groove; the border of that region runs through the tissue.
class ForgedGrids : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(writeMesh(folder_.path() / "block.ply", test::blockMesh(true)));
    BakeOptions options;
    options.unit = "mm";
    options.voxelize.voxel_mm = 0.2;
    options.region = FineRegion{{{-1, 0, 0}, {1, 0, 0}}, 2, 0.1};
    const auto baked = bake({folder_.path() / "block.ply"}, case_, options);
    ASSERT_TRUE(baked) << baked.error().message();

    folder_.write("groove.csv", "t,x,y,z,qw,qx,qy,qz\n0,-1,0,0.2,1,0,0,0\n1,-1,0,-0.5,1,0,0,0\n3,1,0,-0.5,1,0,0,0\n");
    const auto file = findToolFile("round-014", defaultToolFolders());
    ASSERT_TRUE(file);
    tool_ = *file;
  }

  fs::path cut() {
    const fs::path out = folder_.path() / "block.run";
    const auto run = cutCase(case_, tool_, folder_.path() / "groove.csv", out, {});
    EXPECT_TRUE(run) << run.error().message();
    EXPECT_EQ(run ? run->voxel_mm : 0, 0.1) << "in the region";
    return out;
  }

  fs::path cutByHand() {
    const fs::path out = folder_.path() / "hand.run";
    HapticCutOptions options;
    options.hand = HandKind::kFeed;
    const auto run = cutCaseByHand(case_, tool_, folder_.path() / "groove.csv", out, options);
    EXPECT_TRUE(run) << run.error().message();
    return out;
  }

  static BrickField gridOf(const fs::path& file, const std::string& grid) {
    auto field = readVdb(file, grid);
    EXPECT_TRUE(field) << field.error().message();
    return field ? std::move(*field) : BrickField();
  }

  // The file then holds these grids alone, and the manifest says that it is as it was written.
  static void forge(const fs::path& run, const std::string& grid, const BrickField& field) {
    ASSERT_TRUE(writeVdb(run / "run.vdb", {{grid, &field}}));
    auto manifest = readRunManifest(run);
    ASSERT_TRUE(manifest);
    manifest->field_sha256 = *sha256OfFile(run / "run.vdb");
    ASSERT_TRUE(writeRunManifest(run, *manifest));
  }

  std::string refusalOfRegion(const BrickField& whole, const BrickField& fine) {
    const fs::path file = case_ / kCaseAnatomy;
    EXPECT_TRUE(writeVdb(file, {{"phi", &whole}, {"phi_fine", &fine}}));
    auto manifest = readCaseManifest(case_);
    EXPECT_TRUE(manifest);
    manifest->field_sha256 = *sha256OfFile(file);
    EXPECT_TRUE(writeCaseManifest(case_, *manifest));
    const auto read = readCaseRegionField(case_, whole);
    return read ? std::string() : read.error().message();
  }

  static std::string refusalOfExport(const fs::path& run) {
    const auto exported = exportBundle(run);
    return exported ? std::string() : exported.error().message();
  }

  TemporaryFolder folder_;
  fs::path case_ = folder_.path() / "block.case", tool_;
};

TEST_F(ForgedGrids, WhatWasHonestlyBakedAndCutIsRead) {
  EXPECT_EQ(refusalOfExport(cut()), "");
  EXPECT_EQ(refusalOfExport(cutByHand()), "");
  const BrickField whole = gridOf(case_ / kCaseAnatomy, "phi"), fine = gridOf(case_ / kCaseAnatomy, "phi_fine");
  EXPECT_EQ(refusalOfRegion(whole, fine), "");
}

TEST_F(ForgedGrids, ARegionOfNoiseOrOfAnotherObjectIsRefusedByName) {
  const BrickField whole = gridOf(case_ / kCaseAnatomy, "phi"), fine = gridOf(case_ / kCaseAnatomy, "phi_fine");
  const std::string noise = refusalOfRegion(whole, noiseLike(fine));
  for (const char* words : {"anatomy.vdb", "grid phi_fine", "noise: "})
    EXPECT_NE(noise.find(words), noise.npos) << words << " in: " << noise;

  const std::string other = refusalOfRegion(whole, turned(fine));
  for (const char* words : {"anatomy.vdb", "grid phi_fine", "another object: "})
    EXPECT_NE(other.find(words), other.npos) << words << " in: " << other;
}

TEST_F(ForgedGrids, MaterialThatComesFromNowhereIsRefusedByName) {
  const fs::path run = cutByHand();
  BrickField deeper = gridOf(run / "run.vdb", "phi");
  for (std::size_t b = 0; b < deeper.brickCount(); ++b)
    for (float& v : deeper.brick(b)) v -= 0.15f;
  forge(run, "phi", deeper);
  const std::string by_export = refusalOfExport(run);
  for (const char* words : {"run.vdb", "grid phi", "material where there was none: ", "by 0.15 mm", "only takes away"})
    EXPECT_NE(by_export.find(words), by_export.npos) << words << " in: " << by_export;

  HapticCutOptions options;
  options.hand = HandKind::kFeed;
  const auto gone_on = cutCaseByHand(run, tool_, folder_.path() / "groove.csv", folder_.path() / "on.run", options);
  ASSERT_FALSE(gone_on);
  EXPECT_NE(gone_on.error().message().find("material where there was none"), std::string::npos)
      << gone_on.error().message();
}

// A filling in the groove, and a groove in the filling: the second run adds nothing, but began with what the first did.
TEST_F(ForgedGrids, MaterialThatWasAddedIsLetThroughInTheRunsThatGoOn) {
  HapticCutOptions options;
  options.hand = HandKind::kFeed;
  options.add = "composite";
  folder_.write("above.csv", "t,x,y,z,qw,qx,qy,qz\n0,-1,0,0.2,1,0,0,0\n1,-1,0,-0.2,1,0,0,0\n3,1,0,-0.2,1,0,0,0\n");
  const fs::path filled = folder_.path() / "filled.run", cut_again = folder_.path() / "again.run";
  const auto added = cutCaseByHand(case_, tool_, folder_.path() / "above.csv", filled, options);
  ASSERT_TRUE(added) << added.error().message();
  ASSERT_GT(added->summary.added_mm3, 0.1);
  EXPECT_EQ(refusalOfExport(filled), "");

  options.add.clear();
  const auto again = cutCaseByHand(filled, tool_, folder_.path() / "groove.csv", cut_again, options);
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_EQ(again->summary.added_mm3, 0);
  EXPECT_EQ(added->manifest.added_before_mm3, 0);
  EXPECT_NEAR(again->manifest.added_before_mm3, added->summary.added_mm3, 0.05 * added->summary.added_mm3)
      << "is told, since it counts as what is around it";
  EXPECT_EQ(refusalOfExport(cut_again), "");
}

// It is no forgery: its voxels are others.
TEST_F(ForgedGrids, ARunInAFineRegionIsNotGoneOnFromByHandAndIsToldWhy) {
  HapticCutOptions options;
  options.hand = HandKind::kFeed;
  const auto by_hand = cutCaseByHand(cut(), tool_, folder_.path() / "groove.csv", folder_.path() / "on.run", options);
  ASSERT_FALSE(by_hand);
  const std::string told = by_hand.error().message();
  for (const char* words : {"voxels of 0.1 mm", "0.2 mm, as in the case", "finer region"})
    EXPECT_NE(told.find(words), told.npos) << words << " in: " << told;
}

TEST_F(ForgedGrids, AFineCutThatIsGoneOnWithOutsideOfItsRegionIsSaidToBeCoarseNow) {
  const fs::path fine = cut(), coarse = folder_.path() / "coarse.run";
  folder_.write("far.csv", "t,x,y,z,qw,qx,qy,qz\n0,2.6,1.6,0.2,1,0,0,0\n1,2.6,1.6,-1.8,1,0,0,0\n");
  const auto on = cutCase(fine, tool_, folder_.path() / "far.csv", coarse, {});
  ASSERT_TRUE(on) << on.error().message();
  ASSERT_EQ(on->voxel_mm, 0.2);
  EXPECT_EQ(on->finer_before_mm, 0.1);

  folder_.write("on.csv", "t,x,y,z,qw,qx,qy,qz\n0,2.6,1.6,0.2,1,0,0,0\n1,2.6,1.4,-1.8,1,0,0,0\n");
  const auto further = cutCase(coarse, tool_, folder_.path() / "on.csv", folder_.path() / "further.run", {});
  ASSERT_TRUE(further) << further.error().message();
  EXPECT_EQ(further->finer_before_mm, 0) << "it was coarse already";
}

TEST_F(ForgedGrids, ARunOfNoiseIsRefusedByName) {
  const fs::path by_geometry = cut(), by_hand = cutByHand();
  forge(by_geometry, "sweep", noiseLike(gridOf(by_geometry / "run.vdb", "sweep")));
  forge(by_hand, "phi", noiseLike(gridOf(by_hand / "run.vdb", "phi")));
  const std::string sweep = refusalOfExport(by_geometry), phi = refusalOfExport(by_hand);
  for (const char* words : {"run.vdb", "grid sweep", "noise: "})
    EXPECT_NE(sweep.find(words), sweep.npos) << words << " in: " << sweep;
  for (const char* words : {"run.vdb", "grid phi", "noise: "})
    EXPECT_NE(phi.find(words), phi.npos) << words << " in: " << phi;
}

}  // namespace
}  // namespace kerf
