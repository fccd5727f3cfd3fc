// Grids with numbers that are no distances, in cases and runs with matching manifests.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "geometry/base/hash.h"
#include "geometry/case/case_bundle.h"
#include "geometry/field/material_bricks.h"
#include "geometry/field/vdb_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/bake/bake.h"
#include "sim/run/cut/geometry_cut.h"
#include "sim/run/cut/haptic_cut.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "sim/run/report/replay.h"
#include "sim/run/scene/load_scene.h"
#include "sim/run/session/added_materials.h"
#include "sim/session/session.h"
#include "sim/session/session_log.h"
#include "tests/sim/block_scene.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"

namespace kerf::forged_grids_test {
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

// A block with finer voxels around a groove. The border of that region passes through the tissue.
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

  // The file then holds only these grids, and the manifest has its hash.
  static void forge(const fs::path& run, const std::string& grid, const BrickField& field,
                    const MaterialBricks& materials = {}) {
    ASSERT_TRUE(writeVdb(run / "run.vdb", {{grid, &field}}, {}, &materials));
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

// A ridge of composite, and a groove through it and into the block. The second run adds nothing, but starts with the
// first run's material.
class FillingOnABlock : public ForgedGrids {
 protected:
  void SetUp() override {
    ForgedGrids::SetUp();
    folder_.write("above.csv", "t,x,y,z,qw,qx,qy,qz\n0,-1,0,0.2,1,0,0,0\n1,-1,0,-0.2,1,0,0,0\n3,1,0,-0.2,1,0,0,0\n");
    // From above, until the drive is up to speed; slowly, so that all tissue gives way.
    folder_.write(
        "through.csv",
        "t,x,y,z,qw,qx,qy,qz\n0,-1,0,3,1,0,0,0\n2,-1,0,2,1,0,0,0\n12,-1,0,-0.5,1,0,0,0\n32,1,0,-0.5,1,0,0,0\n");
    options_.hand = HandKind::kFeed;
    options_.add = "composite";
    const auto added = cutCaseByHand(case_, tool_, folder_.path() / "above.csv", filled_, options_);
    ASSERT_TRUE(added) << added.error().message();
    added_mm3_ = added->summary.added_mm3;
    ASSERT_GT(added_mm3_, 0.1);
    EXPECT_EQ(added->manifest.added_before_mm3, 0);
    options_.add.clear();
  }

  Expected<HapticCut> cutThrough(const fs::path& from, const std::string& name) {
    return cutCaseByHand(from, tool_, folder_.path() / "through.csv", folder_.path() / name, options_);
  }
  std::string refusalOfGoingOn() {
    const auto cut = cutThrough(filled_, "on.run");
    return cut ? std::string() : cut.error().message();
  }
  MaterialBricks materials() const {
    auto out = readMaterialBricks(filled_ / "run.vdb");
    EXPECT_TRUE(out) << out.error().message();
    return out ? std::move(*out) : MaterialBricks{};
  }

  HapticCutOptions options_;
  fs::path filled_ = folder_.path() / "filled.run";
  double added_mm3_ = 0;
};

TEST_F(FillingOnABlock, MaterialThatWasAddedIsLetThroughInTheRunsThatGoOn) {
  EXPECT_EQ(refusalOfExport(filled_), "");
  const auto again = cutThrough(filled_, "again.run");
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_EQ(again->summary.added_mm3, 0);
  EXPECT_EQ(refusalOfExport(folder_.path() / "again.run"), "");
}

// Both paths in one session: the samples of both logs.
TEST_F(FillingOnABlock, WhatIsCutOffItLaterIsCompositeAsInOneSession) {
  const auto cut = cutThrough(filled_, "through.run");
  ASSERT_TRUE(cut) << cut.error().message();
  EXPECT_EQ(cut->manifest.added_before_mm3, 0) << "nothing is to be told: it is known what it is";

  const auto first = readSessionLog(filled_ / "session.kerflog");
  const auto second = readSessionLog(folder_.path() / "through.run" / "session.kerflog");
  ASSERT_TRUE(first && second);
  const auto object = loadObject(case_);
  ASSERT_TRUE(object) << object.error().message();
  const Tool tools[] = {*readTool(tool_)};
  StepSettings settings;
  settings.rendering = Rendering::kRigid;
  const auto model = makeModel(tools, settings, widestBand(std::span(&*object, 1)));
  ASSERT_TRUE(model) << model.error().message();
  Session session(*model, LoadedObjects{*object}, Rigid3{Eigen::Quaterniond::Identity(), {-1, 0, 0.2}});
  StepOutput tick;
  ASSERT_TRUE(session.apply(AddMaterial{static_cast<std::uint8_t>(Material::kComposite), 0}));
  for (const TimedSample& sample : first->samples) session.tick(sample.sample, tick);
  ASSERT_TRUE(session.apply(StopAdding{}));
  for (const TimedSample& sample : second->samples) session.tick(sample.sample, tick);

  const CutObject& both = session.state().objects.front();
  const std::size_t composite = static_cast<std::size_t>(Material::kComposite);
  const auto in_summary = [](const std::map<std::string, double>& volumes, const char* id) {
    const auto at = volumes.find(id);
    return at == volumes.end() ? 0.0 : at->second;
  };
  const double of_filling = in_summary(cut->summary.removed_by_material, "composite");
  EXPECT_GT(of_filling, 0.05);
  EXPECT_LT(of_filling, added_mm3_ + 1e-9);
  EXPECT_NEAR(of_filling, both.removed_mm3[composite], 1e-6);
  double all = 0;
  for (const double removed : both.removed_mm3) all += removed;
  EXPECT_NEAR(cut->summary.removed_mm3, all, 1e-6);
  EXPECT_GT(all, of_filling + 0.05) << "the block, too";
  EXPECT_NEAR(in_summary(cut->summary.initial_by_material, "composite"), both.added_mm3[composite], 1e-6);
}

// The run itself, a run that continues it, and a run that continues that one: by hand and by geometry.
TEST_F(FillingOnABlock, RunsThatGoOnReplayBitForBitAndHandItsMaterialOn) {
  folder_.write("side.csv", "t,x,y,z,qw,qx,qy,qz\n0,-2.2,-1,1,1,0,0,0\n1,-2.2,-1,-0.6,1,0,0,0\n");
  const fs::path aside = folder_.path() / "aside.run", swept = folder_.path() / "swept.run";
  const auto by_hand = cutCaseByHand(filled_, tool_, folder_.path() / "side.csv", aside, options_);
  ASSERT_TRUE(by_hand) << by_hand.error().message();
  const auto by_geometry = cutCase(filled_, tool_, folder_.path() / "side.csv", swept, {});
  ASSERT_TRUE(by_geometry) << by_geometry.error().message();
  for (const fs::path& run : {filled_, aside}) {
    const auto replayed = replayRun(run);
    ASSERT_TRUE(replayed) << replayed.error().message();
    EXPECT_TRUE(replayed->is_same && replayed->is_whole) << run << replayed->note;
  }

  const auto direct = cutThrough(filled_, "direct.run");
  ASSERT_TRUE(direct) << direct.error().message();
  const double removed = direct->summary.removed_by_material.at("composite");
  for (const fs::path& run : {aside, swept}) {
    const auto cut = cutThrough(run, "from " + run.stem().string() + ".run");
    ASSERT_TRUE(cut) << cut.error().message();
    EXPECT_EQ(cut->manifest.added_before_mm3, 0) << run;
    ASSERT_TRUE(cut->summary.removed_by_material.contains("composite")) << run;
    EXPECT_NEAR(cut->summary.removed_by_material.at("composite"), removed, 1e-6) << run;
  }
  const auto plan = cutCase(filled_, tool_, folder_.path() / "through.csv", folder_.path() / "plan.run", {});
  ASSERT_TRUE(plan) << plan.error().message();
  ASSERT_TRUE(plan->removed_by_material.contains("composite"));
  EXPECT_GE(plan->removed_by_material.at("composite"), 0.99 * removed);
  EXPECT_LE(plan->removed_by_material.at("composite"), added_mm3_ + 1e-6);
}

// A cut separates the block and the ridge on it.
TEST_F(FillingOnABlock, PiecesKeepTheMaterialThatEachOfThemHas) {
  std::string path = "t,x,y,z,qw,qx,qy,qz\n";
  int t = 0;
  for (const double z : {2.0, 0.3, -0.4, -1.1, -1.8, -2.5, -3.2})
    for (const int side : {-1, 1}) path += fmt::format("{},0,{},{},1,0,0,0\n", t++, 3 * side, z);
  folder_.write("across.csv", path);
  const fs::path halves = folder_.path() / "halves.run";
  const auto cut = cutCase(filled_, tool_, folder_.path() / "across.csv", halves, {});
  ASSERT_TRUE(cut) << cut.error().message();

  const auto field = readRunCutField(halves);
  const auto known = readRunMaterials(halves);
  ASSERT_TRUE(field && known);
  const auto whole = loadObject(case_, &*field, &*known);
  ASSERT_TRUE(whole) << whole.error().message();
  const Tool tools[] = {*readTool(tool_)};
  const auto model = makeModel(tools, {}, widestBand(std::span(&*whole, 1)));
  ASSERT_TRUE(model) << model.error().message();
  Session session(*model, LoadedObjects{*whole}, Rigid3{Eigen::Quaterniond::Identity(), {0, 0, 3}});
  ASSERT_TRUE(session.apply(SplitObject{0}));
  const internal::Objects pieces = internal::objectsOf(session, 0);
  ASSERT_EQ(pieces.size(), 2u);

  const auto table = readDefaultMaterials();
  ASSERT_TRUE(table);
  const MaterialBricks kept = internal::addedMaterials(pieces, *known, *table);
  const auto again = loadObject(case_, &*field, &kept);
  ASSERT_TRUE(again) << again.error().message();
  const std::size_t composite = static_cast<std::size_t>(Material::kComposite);
  double of_pieces = 0;
  for (const CutObject* const piece : pieces) {
    const double volume = piece->bricks().countVolumes()[composite];
    EXPECT_GT(volume, 0.1) << "each has a part of it";
    of_pieces += volume;
  }
  EXPECT_NEAR((*again)->volumes()[composite], of_pieces, 0.01 * of_pieces);
  EXPECT_EQ((*again)->volumes(), (*whole)->volumes());
}

// A piece has air at the place of the other one, and air has one material.
TEST_F(FillingOnABlock, WhatIsAddedToAPieceLeavesTheTissuesOfTheOtherAsTheyAre) {
  const auto field = readRunCutField(filled_);
  const auto known = readRunMaterials(filled_);
  ASSERT_TRUE(field && known);
  const auto whole = loadObject(case_, &*field, &*known);  // a block and a ridge of composite: two tissues
  ASSERT_TRUE(whole) << whole.error().message();
  const Tool tools[] = {*readTool(tool_)};
  auto model = makeModel(tools, {}, widestBand(std::span(&*whole, 1)));
  ASSERT_TRUE(model) << model.error().message();
  model->settings.rendering = Rendering::kRigid;
  model->settings.geometry_only = true;

  Session session(*model, LoadedObjects{*whole}, Rigid3{Eigen::Quaterniond::Identity(), {0, -3, 3}});
  session.splitWhenApart(1 << 30);
  StepOutput out;
  const auto goTo = [&](const Vec3d& from, const Vec3d& to) {
    constexpr int kSteps = 400;
    for (int n = 0; n <= kSteps; ++n) {
      const Vec3d at = from + (to - from) * n / kSteps;
      session.tick(test::sampleAt({Eigen::Quaterniond::Identity(), at}, n < kSteps ? 1 : 0), out);
    }
  };
  for (const double z : {2.0, 0.3, -0.4, -1.1, -1.8, -2.5, -3.2}) goTo({0, -3, z}, {0, 3, z});
  ASSERT_TRUE(session.apply(SplitObject{0}));
  const internal::Objects pieces = internal::objectsOf(session, 0);
  ASSERT_EQ(pieces.size(), 2u);
  const auto left = static_cast<std::uint32_t>(session.object(0).bricks().field().bounds().min[0] < -1.5 ? 0 : 1);

  // The left piece gets pulp at the place of the ridge's end on the right piece.
  goTo({2.6, 0, 3}, {2.6, 0, 3});
  constexpr auto kPulp = static_cast<std::uint8_t>(Material::kPulp);
  ASSERT_TRUE(session.apply(AddMaterial{kPulp, left}));
  goTo({2.6, 0.4, 0.5}, {0.9, 0.4, 0.5});

  const auto table = readDefaultMaterials();
  ASSERT_TRUE(table);
  const MaterialBricks kept = internal::addedMaterials(pieces, {}, *table);
  ASSERT_FALSE(kept.isEmpty());
  std::size_t pulp = 0, composite = 0, wrong = 0;
  for (std::size_t b = 0; b < kept.bricks.size(); ++b) {
    const std::int32_t slot = (*whole)->directory().find(kept.bricks[b]);
    if (slot < 0) continue;
    for (std::size_t n = 0; n < kBrickNodes; ++n) {
      const std::uint8_t loaded = (*whole)->slots()[static_cast<std::size_t>(slot)].materials[n];
      const std::uint8_t number = kept.numbers[b][n];
      pulp += number == kPulp;
      composite += number == static_cast<std::uint8_t>(Material::kComposite);
      wrong += number != kPulp && number != loaded;
    }
  }
  EXPECT_GT(pulp, 100u);
  EXPECT_GT(composite, 10u);
  EXPECT_EQ(wrong, 0u);
  EXPECT_TRUE(kept.added.contains(kPulp));
}

// An older Kerf stored no materials.
TEST_F(FillingOnABlock, OfARunWithoutMaterialsItIsToldThatItCountsAsWhatIsAroundIt) {
  forge(filled_, "phi", gridOf(filled_ / "run.vdb", "phi"));
  const auto cut = cutThrough(filled_, "old.run");
  ASSERT_TRUE(cut) << cut.error().message();
  EXPECT_NEAR(cut->manifest.added_before_mm3, added_mm3_, 0.05 * added_mm3_);
  EXPECT_FALSE(cut->summary.removed_by_material.contains("composite"));
  EXPECT_TRUE(readMaterialBricks(folder_.path() / "old.run" / "run.vdb")->isEmpty()) << "it is still not known";
}

TEST_F(FillingOnABlock, MaterialsThatTheCaseNeverHadAreRefusedByName) {
  const BrickField phi = gridOf(filled_ / "run.vdb", "phi");
  const MaterialBricks good = materials();
  ASSERT_EQ(good.added, (std::map<std::uint8_t, std::string>{{11, "composite"}}));
  const auto expectRefused = [&](const MaterialBricks& bad, std::initializer_list<const char*> said) {
    forge(filled_, "phi", phi, bad);
    const std::string refusal = refusalOfGoingOn();
    EXPECT_NE(refusal.find("run.vdb"), refusal.npos) << refusal;
    for (const char* words : said) EXPECT_NE(refusal.find(words), refusal.npos) << words << " in: " << refusal;
  };

  MaterialBricks other = good;
  other.numbers.front()[77] = static_cast<std::uint8_t>(Material::kEnamel);
  expectRefused(other, {"grid material", "material 1 at (", "added material: 11 (composite)"});
  other = good;
  other.added.clear();
  expectRefused(other, {"grid material", "material 11 at (", "added material: none"});
  other = good;
  other.added[11] = "gum";
  expectRefused(other, {"grid material, gum", "number 11, which is 'composite'"});
  other = good;
  other.voxel = 0.1;
  expectRefused(other, {"grid material", "voxels of 0.1 mm", "0.2 mm, as in the case"});
  forge(filled_, "phi", phi, good);
  EXPECT_EQ(refusalOfGoingOn(), "");
}

TEST_F(FillingOnABlock, MaterialsOfARunThatNeverAddedAnyAreRefused) {
  const MaterialBricks of_another = materials();
  const fs::path run = cutByHand();
  forge(run, "phi", gridOf(run / "run.vdb", "phi"), of_another);
  const auto cut = cutThrough(run, "on.run");
  ASSERT_FALSE(cut);
  EXPECT_NE(cut.error().message().find("without filling"), std::string::npos) << cut.error().message();
}

// No forgery, but other voxels.
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
}  // namespace kerf::forged_grids_test
