// Path cuts that continue a run of any origin.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "sim/run/cut/geometry_cut.h"
#include "sim/run/cut/haptic_cut.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "sim/run/report/replay.h"
#include "tests/sim/person_at_mouse.h"

namespace kerf::cut_run_test {
namespace {

namespace fs = std::filesystem;

class CutRunTest : public testing::Test {
 protected:
  // Down into the block at each place, and out again.
  fs::path holes(const std::string& name, const std::vector<Vec3d>& places) const {
    std::string rows = "t,x,y,z,qw,qx,qy,qz\n";
    double t = 0;
    for (const Vec3d& at : places) {
      const auto row = [&](double z) {
        rows += fmt::format("{},{},{},{},1,0,0,0\n", t, at[0], at[1], z);
        t += 1.5;
      };
      row(2.5);
      row(at[2]);
      row(2.5);
    }
    return folder_.write(name, rows);
  }
  // Right through the block, from side to side, layer by layer.
  fs::path slot(const std::string& name, double x, double from = -0.3, double to = -4, double seconds = 2) const {
    std::string rows = "t,x,y,z,qw,qx,qy,qz\n";
    double t = 0, y = -3;
    for (double z = from; z > to; z -= 0.5) {
      rows += fmt::format("{},{},{},{},1,0,0,0\n", t, x, y, z);
      y = -y;
      rows += fmt::format("{},{},{},{},1,0,0,0\n", t + seconds, x, y, z);
      t += 2 * seconds;
    }
    return folder_.write(name, rows);
  }
  fs::path at(const std::string& name) const { return folder_.path() / name; }
  RunManifest geometry(const std::string& from, const fs::path& path, const std::string& run) const {
    const auto cut = cutCase(at(from), tool_, path, at(run));
    EXPECT_TRUE(cut) << cut.error().message();
    return cut ? *cut : RunManifest();
  }
  HapticCut byHand(const std::string& from, const fs::path& path, const std::string& run,
                   const std::vector<fs::path>& beside = {}) const {
    HapticCutOptions options;
    options.beside = beside;
    auto cut = cutCaseByHand(at(from), tool_, path, at(run), options);
    EXPECT_TRUE(cut) << cut.error().message();
    return cut ? std::move(*cut) : HapticCut();
  }
  Export exported(const std::string& run, std::size_t beside = 0) const {
    auto out = exportBundle(at(run), {}, {}, beside);
    EXPECT_TRUE(out) << out.error().message();
    return out ? std::move(*out) : Export();
  }
  double removedIn(const std::string& run, std::size_t beside = 0) const {
    return exported(run, beside).post_op.report.removed_volume_mm3;
  }
  void expectReplays(const std::string& run) const {
    const auto replayed = replayRun(at(run));
    ASSERT_TRUE(replayed) << replayed.error().message();
    EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  }
  // A run of two halves, last cut against resistance. A person moved the right half.
  void cutInHalves(const Vec3d& moved) const {
    test::bakedBlock(folder_);
    geometry("block.case", slot("slot.csv", 0), "slot.run");
    byHand("slot.run", holes("hole.csv", {{-2, 1, -0.6}}), "halves.run");
    RunManifest manifest = *readRunManifest(at("halves.run"));
    manifest.pieces.resize(2);
    manifest.pieces[0].name = "left";
    manifest.pieces[0].inside = {-1.8, 0, -1.5};
    manifest.pieces[1].name = "right";
    manifest.pieces[1].inside = {1.8, 0, -1.5};
    manifest.pieces[1].colour = "sky";
    manifest.pieces[1].T_case_piece.translation = moved;
    ASSERT_TRUE(writeRunManifest(at("halves.run"), manifest));
  }

  TemporaryFolder folder_;
  fs::path tool_ = *findToolFile("round-014", defaultToolFolders());
};

TEST_F(CutRunTest, GeometryThatGoesOnIsThatOfOneCutToTheBit) {
  test::bakedBlock(folder_);
  const Vec3d a(-2, 0, -0.5), b(-1.5, 0.4, -0.8), c(1.5, 0, -1);
  geometry("block.case", holes("a.csv", {a}), "a.run");
  const RunManifest two = geometry("a.run", holes("b.csv", {b}), "ab.run");
  const RunManifest three = geometry("ab.run", holes("c.csv", {c}), "abc.run");
  const RunManifest once = geometry("block.case", holes("all.csv", {a, b, c}), "once.run");
  EXPECT_EQ(two.earlier.size(), 1u);
  EXPECT_EQ(three.earlier.size(), 2u);
  EXPECT_EQ(three.state_hash, once.state_hash);
  EXPECT_EQ(three.removed_by_material, once.removed_by_material);
  EXPECT_EQ(three.segments, 2u) << "of the last path";

  const Export one = exported("once.run"), further = exported("abc.run");
  EXPECT_EQ(one.post_op.mesh.vertices, further.post_op.mesh.vertices);
  EXPECT_EQ(one.post_op.mesh.triangles, further.post_op.mesh.triangles);
  EXPECT_GT(further.accuracy.vertices, 100u);
  EXPECT_NEAR(further.accuracy.max_mm, one.accuracy.max_mm, 1e-9) << "of all paths";
  EXPECT_LT(further.accuracy.max_mm, 0.02);

  // The path meets no remaining tissue. Kerf checks the inputs of earlier cuts.
  const auto again = cutCase(at("abc.run"), tool_, at("c.csv"), at("again.run"));
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, Error::Code::kEmpty);
  EXPECT_FALSE(fs::exists(at("again.run")));
  std::ofstream(at("abc.run/earlier/01/path.csv"), std::ios::app) << "9,0,0,0,1,0,0,0\n";
  EXPECT_FALSE(exportBundle(at("abc.run")));
  EXPECT_FALSE(cutCase(at("abc.run"), tool_, holes("d.csv", {{0, 1, -1}}), at("d.run")));
  EXPECT_FALSE(cutCase(at("ab.run"), tool_, at("c.csv"), at("ab.run"), {.overwrite = true})) << "its own beginning";
}

TEST_F(CutRunTest, GeometryGoesOnFromACutAgainstResistance) {
  test::bakedBlock(folder_);
  const HapticCut first = byHand("block.case", holes("a.csv", {{-2, 0, -0.6}}), "a.run");
  const RunManifest second = geometry("a.run", holes("b.csv", {{1.5, 0, -1}}), "ab.run");
  geometry("block.case", at("b.csv"), "b.run");
  EXPECT_EQ(second.mode, kModeGeometry);
  EXPECT_EQ(second.begin_sha256, first.manifest.field_sha256);
  const double a = removedIn("a.run"), b = removedIn("b.run");
  ASSERT_GT(a, 0.1);
  EXPECT_NEAR(removedIn("ab.run"), a + b, 0.02 * (a + b));
  EXPECT_NEAR(second.removed_by_material.begin()->second, b, 0.05 * b) << "since then";
  EXPECT_NE(exported("ab.run").accuracy_missing.find("continues a run"), std::string::npos);

  // Continues by hand and by geometry.
  byHand("ab.run", holes("c.csv", {{-2, -1, -0.6}}), "abc.run");
  expectReplays("abc.run");
  geometry("ab.run", holes("d.csv", {{0, 1, -1}}), "abd.run");
  EXPECT_GT(removedIn("abc.run"), a + b + 0.1);
  EXPECT_GT(removedIn("abd.run"), a + b + 0.1);
}

TEST_F(CutRunTest, WhatStoodBesideStandsThereAgainAsItWasLeft) {
  test::bakedBlock(folder_);
  const fs::path other = test::bakedBlock(folder_, "other", {7, 0, 0});
  const HapticCut first = byHand("block.case", holes("a.csv", {{2, 0, -0.6}, {5, 0, -0.6}}), "a.run", {other});
  ASSERT_EQ(first.manifest.beside.size(), 1u);
  const double before = first.manifest.beside[0].removed_mm3;
  ASSERT_GT(before, 0.1);

  const HapticCut second = byHand("a.run", holes("b.csv", {{-2, 0, -0.6}, {8, 0, -0.6}}), "b.run");
  ASSERT_EQ(second.manifest.beside.size(), 1u);
  EXPECT_TRUE(second.manifest.beside[0].has_begin);
  EXPECT_NEAR(second.summary.beside[0].removed_mm3, before, 0.1 * before) << "of this cut alone";
  EXPECT_NEAR(second.manifest.beside[0].removed_mm3, 2 * before, 0.1 * before) << "of both";
  expectReplays("b.run");
  EXPECT_NEAR(removedIn("b.run", 1), 2 * removedIn("a.run", 1), 0.1 * before);
  EXPECT_NEAR(removedIn("b.run"), 2 * removedIn("a.run"), 0.1 * removedIn("a.run"));

  // Another block beside; and geometry, which sweeps the whole scene.
  const fs::path third = test::bakedBlock(folder_, "third", {-7, 0, 0});
  const HapticCut more = byHand("b.run", holes("c.csv", {{0, 0, -0.6}}), "c.run", {third});
  ASSERT_EQ(more.manifest.beside.size(), 2u);
  EXPECT_FALSE(more.manifest.beside[1].has_begin);
  expectReplays("c.run");
  const double second_and_third = more.manifest.beside[0].removed_mm3;
  const RunManifest swept = geometry("c.run", holes("d.csv", {{0, 1, -0.6}, {7, 0, -1}}), "d.run");
  ASSERT_EQ(swept.beside.size(), 2u);
  EXPECT_GT(swept.beside[0].removed_mm3, 2.5 * before);
  EXPECT_NEAR(swept.beside[0].removed_now_mm3, swept.beside[0].removed_mm3 - second_and_third, 1e-9);
  EXPECT_NEAR(removedIn("d.run", 1), swept.beside[0].removed_mm3, 0.05 * swept.beside[0].removed_mm3);
  EXPECT_EQ(swept.beside[1].removed_mm3, 0);

  HapticCutOptions with_it;
  with_it.beside = {other};
  const auto twice = cutCaseByHand(at("a.run"), tool_, at("b.csv"), at("x.run"), with_it);
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().message().find("same case"), std::string::npos) << twice.error().message();
}

TEST_F(CutRunTest, PiecesAreCutByHandWhereTheyWerePut) {
  const Vec3d moved(2, 0, 1);
  ASSERT_NO_FATAL_FAILURE(cutInHalves(moved));
  const double before = removedIn("halves.run");
  const Vec3d in_the_right = Vec3d(1.8, 0, -0.6) + moved;
  const HapticCut cut = byHand("halves.run", holes("c.csv", {in_the_right}), "c.run");
  EXPECT_TRUE(cut.manifest.missing_pieces.empty());
  EXPECT_GT(cut.summary.removed_mm3, 0.1);
  EXPECT_GT(cut.summary.reached_mm3, 0.5 * cut.summary.planned_mm3) << "the plan is in the piece, too";
  expectReplays("c.run");

  const auto manifest = readRunManifest(at("c.run"));
  ASSERT_TRUE(manifest) << manifest.error().message();
  ASSERT_EQ(manifest->pieces.size(), 2u);
  const auto right = std::find_if(manifest->pieces.begin(), manifest->pieces.end(),
                                  [](const RunManifest::Piece& piece) { return piece.name == "right"; });
  ASSERT_NE(right, manifest->pieces.end());
  EXPECT_EQ(right->colour, "sky");
  EXPECT_EQ(right->T_case_piece.translation, moved);
  EXPECT_NEAR(removedIn("c.run") - before, cut.summary.removed_mm3, 0.05 * cut.summary.removed_mm3);

  // At its old place in the scan's frame, where nothing remains.
  const auto nothing = cutCaseByHand(at("halves.run"), tool_, holes("none.csv", {{1.8, 0, 0.5}}), at("none.run"));
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, Error::Code::kEmpty);
}

TEST_F(CutRunTest, PiecesAreSweptWhereTheyWerePut) {
  const Vec3d moved(2, 0, 1);  // whole voxels
  ASSERT_NO_FATAL_FAILURE(cutInHalves(moved));
  const double before = removedIn("halves.run");
  const RunManifest cut = geometry("halves.run", holes("c.csv", {Vec3d(1.8, 0, -0.6) + moved}), "c.run");
  ASSERT_EQ(cut.pieces.size(), 2u);
  EXPECT_EQ(cut.findings.strokes, 1u);
  const double removed = cut.removed_by_material.begin()->second;
  EXPECT_GT(removed, 0.3);
  EXPECT_NEAR(removedIn("c.run") - before, removed, 0.05 * removed);

  const auto nothing = cutCase(at("halves.run"), tool_, holes("none.csv", {{1.6, 0, -1}}), at("none.run"));
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, Error::Code::kEmpty);

  // The same result as in the undivided object, at the piece's old place.
  RunManifest whole = *readRunManifest(at("halves.run"));
  whole.pieces.clear();
  ASSERT_TRUE(writeRunManifest(at("halves.run"), whole));
  const RunManifest there = geometry("halves.run", holes("there.csv", {{1.8, 0, -0.6}}), "there.run");
  EXPECT_NEAR(there.removed_by_material.begin()->second, removed, 1e-3 * removed);
  EXPECT_NEAR(removedIn("there.run"), removedIn("c.run"), 1e-3 * removed);
}

// A cut splits a displaced half: both parts stay there, and neither has the name of another piece.
void expectPartsStayAside(const RunManifest& run, const Vec3d& moved) {
  ASSERT_EQ(run.pieces.size(), 3u);
  std::set<std::string> names;
  std::set<std::uint32_t> ids;
  int aside = 0;
  for (const RunManifest::Piece& piece : run.pieces) {
    names.insert(piece.name);
    ids.insert(piece.id);
    if (!piece.isMoved()) continue;
    ++aside;
    EXPECT_EQ(piece.T_case_piece.translation, moved) << piece.name;
    EXPECT_EQ(piece.colour, "sky") << "as the half that it is of";
    EXPECT_GT(piece.inside[0], 0) << piece.name;
  }
  EXPECT_EQ(aside, 2);
  EXPECT_EQ(names.size(), 3u);
  EXPECT_EQ(ids.size(), 3u);
  EXPECT_TRUE(names.contains("left") && names.contains("right"));
}

TEST_F(CutRunTest, APieceThatIsCutInTwoIsTwoPiecesWhereItWasPut) {
  const Vec3d moved(4, 0, 0);
  ASSERT_NO_FATAL_FAILURE(cutInHalves(moved));
  const double x = 1.8 + moved[0];
  geometry("halves.run", slot("most.csv", x, -0.3, -2.5), "most.run");
  const fs::path rest = slot("rest.csv", x, -2.6, -4, 4);
  expectPartsStayAside(geometry("most.run", rest, "swept.run"), moved);
  ASSERT_FALSE(HasFatalFailure());
  const HapticCut by_hand = byHand("most.run", rest, "by_hand.run");
  EXPECT_GT(by_hand.summary.reached_mm3, 0.9 * by_hand.summary.planned_mm3);
  expectPartsStayAside(by_hand.manifest, moved);

  // The same in a run that continues it.
  const RunManifest further = geometry("swept.run", holes("left.csv", {{-2, -1, -1}}), "further.run");
  EXPECT_TRUE(further.missing_pieces.empty());
  expectPartsStayAside(further, moved);

  // A run that names only one of the two parts: Kerf reports the other.
  RunManifest older = *readRunManifest(at("swept.run"));
  std::erase_if(older.pieces, [](const auto& piece) { return piece.name != "left" && piece.name != "right"; });
  ASSERT_TRUE(writeRunManifest(at("swept.run"), older));
  const RunManifest torn = geometry("swept.run", at("left.csv"), "torn.run");
  ASSERT_EQ(torn.missing_pieces.size(), 1u);
  EXPECT_NE(torn.missing_pieces.front().find("without an entry"), std::string::npos) << torn.missing_pieces.front();
}

TEST_F(CutRunTest, APieceThatIsSweptAwayIsNoPieceAnyMore) {
  ASSERT_NO_FATAL_FAILURE(cutInHalves({4, 0, 0}));
  // Layer by layer, lane by lane, over the whole right half.
  std::string rows = "t,x,y,z,qw,qx,qy,qz\n";
  double t = 0, y = -3;
  for (double z = -0.3; z > -4; z -= 0.5)
    for (double x = 4.2; x < 7.6; x += 0.4) {
      rows += fmt::format("{},{},{},{},1,0,0,0\n{},{},{},{},1,0,0,0\n", t, x, y, z, t + 1, x, -y, z);
      y = -y;
      t += 2;
    }
  const RunManifest swept = geometry("halves.run", folder_.write("all.csv", rows), "swept.run");
  ASSERT_EQ(swept.pieces.size(), 1u);
  EXPECT_EQ(swept.pieces[0].name, "left");
  EXPECT_EQ(swept.pieces_cut_away, std::vector<std::string>{"right"});
}

TEST_F(CutRunTest, APathThatMissesMovedPiecesIsToldWhereTheyAre) {
  ASSERT_NO_FATAL_FAILURE(cutInHalves({20, 0, 0}));
  const fs::path none = holes("none.csv", {{1.8, 0, -0.6}});
  const auto swept = cutCase(at("halves.run"), tool_, none, at("none.run"));
  const auto by_hand = cutCaseByHand(at("halves.run"), tool_, none, at("none.run"));
  ASSERT_FALSE(swept || by_hand);
  for (const std::string& told : {swept.error().message(), by_hand.error().message()}) {
    EXPECT_NE(told.find("(23.0"), told.npos) << told;
    EXPECT_NE(told.find("positions of the pieces"), told.npos) << told;
  }
}

TEST_F(CutRunTest, GeometryGoesOnOnlyFromWhatItsPathsGive) {
  test::bakedBlock(folder_);
  geometry("block.case", holes("a.csv", {{-2, 0, -0.5}}), "a.run");
  holes("b.csv", {{1.5, 0, -1}});
  RunManifest manifest = *readRunManifest(at("a.run"));
  manifest.state_hash = "0123456789abcdef";
  ASSERT_TRUE(writeRunManifest(at("a.run"), manifest));
  const auto other = cutCase(at("a.run"), tool_, at("b.csv"), at("b.run"));
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message().find("state_hash"), std::string::npos) << other.error().message();

  fs::remove(at("a.run/run.vdb"));
  const auto without = cutCase(at("a.run"), tool_, at("b.csv"), at("b.run"));
  ASSERT_FALSE(without);
  EXPECT_NE(without.error().message().find("run.vdb"), std::string::npos) << without.error().message();
}

}  // namespace
}  // namespace kerf::cut_run_test
