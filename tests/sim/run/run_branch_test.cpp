#include "sim/run/session/run_branch.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>

#include "sim/run/cut/haptic_cut.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "sim/run/report/replay.h"
#include "tests/sim/person_at_mouse.h"

namespace kerf::run_branch_test {
namespace {

namespace fs = std::filesystem;

// Two strokes. The second is undone and replaced.
class RunBranchTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder();
    const fs::path block = test::bakedBlock(*folder_);
    auto run = LiveRun::open(block, runFolder(), test::someTools());
    ASSERT_TRUE(run) << run.error().message();
    test::Mouse mouse(**run);
    mouse.drill({-1.5, 0, 0}, 2);
    first_ = removedBy(**run);
    first_ended_ = (*run)->thread().report().tick;
    mouse.send(SelectTool{1});
    mouse.drill({0, 0, 0}, 2);
    second_ = removedBy(**run);
    const UndoList undo = (*run)->thread().report().undo;
    ASSERT_EQ(undo.newest_count, 2u);
    second_began_ = undo.newest[1].origin.tick;
    mouse.send(Undo{});
    mouse.drill({1.5, 0, 0}, 2);
    third_ = removedBy(**run);
    third_began_ = (*run)->thread().report().undo.newest[1].origin.tick;
    const auto ended = (*run)->finish();
    ASSERT_TRUE(ended) << ended.error().message();
    ASSERT_GT(second_, first_ + 0.01);
    ASSERT_GT(third_, first_ + 0.01);
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path runFolder() { return folder_->path() / "block.run"; }
  static double removedBy(LiveRun& run) {
    run.thread().update();
    const HapticReport& report = run.thread().report();
    double out = 0;
    for (std::size_t n = 0; n < report.object_count; ++n) out += report.objects[n].removed_mm3;
    return out;
  }
  // A complete run: it replays, and exports its cut.
  static void expectHolds(const fs::path& branch, double removed) {
    const auto replayed = replayRun(branch);
    ASSERT_TRUE(replayed) << replayed.error().message();
    EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
    EXPECT_TRUE(replayed->note.empty()) << replayed->note;
    EXPECT_NEAR(replayed->removed_mm3, removed, 1e-9);
    const auto exported = exportBundle(branch);
    ASSERT_TRUE(exported) << exported.error().message();
    EXPECT_NEAR(exported->post_op.report.removed_volume_mm3, removed, 0.05 * removed);
  }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline double first_ = 0, second_ = 0, third_ = 0;
  static inline std::uint64_t first_ended_ = 0, second_began_ = 0, third_began_ = 0;
};

TEST_F(RunBranchTest, AStrokeThatWasTakenBackAndReplacedIsInABranch) {
  const fs::path branch = folder_->path() / "second.run";
  const auto written = branchRun(runFolder(), {.step_began = second_began_}, branch);
  ASSERT_TRUE(written) << written.error().message();
  EXPECT_EQ(written->tool_id, "round-014, round-010");
  EXPECT_LT(written->duration_s, readRunManifest(runFolder())->duration_s);
  expectHolds(branch, second_);
  expectHolds(runFolder(), third_);
}

TEST_F(RunBranchTest, AnyMomentIsABranch) {
  const fs::path branch = folder_->path() / "first.run";
  const auto written = branchRun(runFolder(), {.sample = first_ended_}, branch);
  ASSERT_TRUE(written) << written.error().message();
  EXPECT_EQ(written->tool_id, "round-014");
  expectHolds(branch, first_);

  // During a stroke.
  const fs::path middle = folder_->path() / "middle.run";
  ASSERT_TRUE(branchRun(runFolder(), {.sample = second_began_ + 1500}, middle));
  const auto replayed = replayRun(middle);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_GT(replayed->removed_mm3, first_);
  EXPECT_LT(replayed->removed_mm3, second_);
}

// Also from a run that continues a branch: its log begins with begin.vdb.
TEST_F(RunBranchTest, ABranchIsGoneOnFromAndBranchedFromAgain) {
  const fs::path branch = folder_->path() / "base.run", next = folder_->path() / "next.run";
  ASSERT_TRUE(branchRun(runFolder(), {.step_began = second_began_}, branch));
  LiveRunOptions options = test::someTools();
  options.from = branch;
  std::uint64_t began = 0;
  double after_one = 0;
  {
    auto run = LiveRun::open(folder_->path() / "block.case", next, options);
    ASSERT_TRUE(run) << run.error().message();
    EXPECT_NEAR((*run)->removedBefore(), second_, 1e-6);
    test::Mouse mouse(**run);
    mouse.drill({1.5, 1, 0}, 1.5);
    after_one = removedBy(**run);
    began = (*run)->thread().report().undo.newest[0].origin.tick;
    mouse.send(Undo{});
    mouse.drill({1.5, -1, 0}, 1.5);
    ASSERT_TRUE((*run)->finish());
  }

  const fs::path again = folder_->path() / "again.run";
  const auto written = branchRun(next, {.step_began = began}, again);
  ASSERT_TRUE(written) << written.error().message();
  const auto replayed = replayRun(again);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_NEAR(replayed->removed_mm3, after_one, 1e-9);
  const auto exported = exportBundle(again);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_NEAR(exported->post_op.report.removed_volume_mm3, second_ + after_one, 0.05 * (second_ + after_one));
}

// Cuts and moves of the previous run are there from the first moment, before this run cuts.
TEST_F(RunBranchTest, BeforeTheFirstStrokeOfARunThatGoesOnThereIsWhatItBeganWith) {
  const fs::path moved = folder_->path() / "moved.run", next = folder_->path() / "beyond.run";
  LiveRunOptions options = test::someTools();
  options.from = runFolder();
  {
    auto run = LiveRun::open(folder_->path() / "block.case", moved, options);
    ASSERT_TRUE(run) << run.error().message();
    test::Mouse mouse(**run);
    mouse.send(SelectTool{1});  // some ticks earlier
    mouse.send(MoveObject{0, {0, 0, 2}});
    const auto ended = (*run)->finish();
    ASSERT_TRUE(ended) << ended.error().message();
    ASSERT_EQ(ended->pieces.size(), 1u);
  }
  options.from = moved;
  {
    auto run = LiveRun::open(folder_->path() / "block.case", next, options);
    ASSERT_TRUE(run) << run.error().message();
    test::Mouse mouse(**run);
    mouse.send(SelectTool{1});
    mouse.send(MoveObject{0, {0, 0, 4}});
    ASSERT_TRUE((*run)->finish());
  }

  const auto expectBegins = [](const fs::path& run, std::size_t sample, std::size_t pieces) {
    const fs::path branch = folder_->path() / fmt::format("{} {}.run", run.stem().string(), sample);
    const auto written = branchRun(run, {.sample = sample}, branch);
    ASSERT_TRUE(written) << written.error().message();
    ASSERT_EQ(written->pieces.size(), pieces);
    for (const RunManifest::Piece& piece : written->pieces)
      EXPECT_EQ(piece.T_case_piece.translation, Vec3d(0, 0, 2)) << sample;
    const auto replayed = replayRun(branch);
    ASSERT_TRUE(replayed) << replayed.error().message();
    EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
    const auto exported = exportBundle(branch);
    ASSERT_TRUE(exported) << exported.error().message();
    EXPECT_NEAR(exported->post_op.report.removed_volume_mm3, third_, 0.05 * third_);
  };
  for (const std::size_t sample : {0u, 5u}) {
    expectBegins(moved, sample, 0);
    expectBegins(next, sample, 1);
  }
}

// A branch of `kerf cut --add` is a session, without the summary of the added material.
TEST_F(RunBranchTest, ABranchOfARunThatAddedMaterialIsGoneOnFrom) {
  const fs::path block = folder_->path() / "block.case", filled = folder_->path() / "filled.run";
  const fs::path branch = folder_->path() / "filling.run";
  const fs::path path =
      folder_->write("above.csv", "t,x,y,z,qw,qx,qy,qz\n0,-1,0,0.2,1,0,0,0\n1,-1,0,-0.2,1,0,0,0\n3,1,0,-0.2,1,0,0,0\n");
  HapticCutOptions adding;
  adding.hand = HandKind::kFeed;
  adding.add = "composite";
  const auto added = cutCaseByHand(block, *findToolFile("round-014", defaultToolFolders()), path, filled, adding);
  ASSERT_TRUE(added) << added.error().message();
  ASSERT_GT(added->summary.added_mm3, 0.1);

  const auto written = branchRun(filled, {.sample = 2000}, branch);
  ASSERT_TRUE(written) << written.error().message();
  const auto exported = exportBundle(branch);
  ASSERT_TRUE(exported) << exported.error().message();
  const auto materials = readRunMaterials(branch);
  ASSERT_TRUE(materials) << materials.error().message();
  EXPECT_EQ(materials->added, (std::map<std::uint8_t, std::string>{{11, "composite"}}));
  LiveRunOptions options = test::someTools();
  options.from = branch;
  const auto run = LiveRun::open(block, folder_->path() / "on the filling.run", options);
  ASSERT_TRUE(run) << run.error().message();
  EXPECT_EQ((*run)->addedBefore(), 0) << "nothing is to be told";
  EXPECT_GT((*run)->object().volumes()[11], 0.1);

  fs::remove(filled / "summary.json");
  EXPECT_TRUE(exportBundle(filled)) << "the log says it, too";
}

// The program is killed before it has deleted the log of an empty session.
TEST_F(RunBranchTest, WhatWasTakenBackIsFoundInTheLogOfAnEmptySession) {
  EXPECT_EQ(*droppedSteps(runFolder()), std::vector<std::uint64_t>{second_began_});

  const fs::path lost = folder_->path() / "lost.run";
  double first = 0, second = 0;
  {
    auto run = LiveRun::open(folder_->path() / "block.case", lost, test::someTools());
    ASSERT_TRUE(run) << run.error().message();
    test::Mouse mouse(**run);
    mouse.drill({-1.5, 0, 0}, 1.5);
    first = removedBy(**run);
    mouse.send(Undo{});
    mouse.drill({1.5, 0, 0}, 1);
    second = removedBy(**run);
    mouse.send(Undo{});
    EXPECT_EQ((*run)->finish(true).error().code, Error::Code::kEmpty);
  }
  const auto recovered = recoverRun(lost);
  ASSERT_FALSE(recovered);
  EXPECT_EQ(recovered.error().code, Error::Code::kEmpty);
  EXPECT_NE(recovered.error().hint.find("session.recover"), std::string::npos) << recovered.error().message();

  const auto dropped = droppedSteps(lost);
  ASSERT_TRUE(dropped) << dropped.error().message();
  ASSERT_EQ(dropped->size(), 2u);
  const double removed[] = {first, second};
  for (std::size_t n = 0; n < 2; ++n) {
    const fs::path branch = folder_->path() / ("found " + std::to_string(n) + ".run");
    const auto written = branchRun(lost, {.step_began = (*dropped)[n]}, branch);
    ASSERT_TRUE(written) << written.error().message();
    expectHolds(branch, removed[n]);
  }
  fs::remove_all(lost);
}

// Killed while writing the log, it is no run: neither a finished run nor one to recover.
TEST_F(RunBranchTest, ABranchThatWasHalfWrittenIsNoRun) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  setenv("KERF_TEST_BRANCHED", runFolder().c_str(), 0);  // the child has its own folder
  const fs::path run = std::getenv("KERF_TEST_BRANCHED");
  const auto bytes = fs::file_size(runFolder() / "session.kerflog");
  const auto branchWithLittleRoom = [&] {
    const rlimit most{bytes / 2, bytes / 2};
    setrlimit(RLIMIT_FSIZE, &most);
    signal(SIGXFSZ, SIG_DFL);
    (void)branchRun(run, {.step_began = {}}, run.parent_path() / "half.run");
  };
  EXPECT_EXIT(branchWithLittleRoom(), testing::KilledBySignal(SIGXFSZ), "");
  unsetenv("KERF_TEST_BRANCHED");

  EXPECT_FALSE(fs::exists(folder_->path() / "half.run"));
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_->path())) {
    const auto manifest = readRunManifest(entry.path());
    EXPECT_FALSE(manifest && manifest->is_open) << entry.path();
  }
}

TEST_F(RunBranchTest, AStrokeThatWasNotTakenBackLeadsToTheEnd) {
  const fs::path branch = folder_->path() / "end.run";
  const auto written = branchRun(runFolder(), {.step_began = third_began_}, branch);
  ASSERT_TRUE(written) << written.error().message();
  EXPECT_EQ(written->state_hash, readRunManifest(runFolder())->state_hash);
}

TEST_F(RunBranchTest, WhatCanNotBeABranchIsRefusedAndLeavesNothing) {
  const fs::path branch = folder_->path() / "none.run";
  const auto nothing = branchRun(runFolder(), {.sample = 10}, branch);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, Error::Code::kEmpty);
  EXPECT_NE(nothing.error().hint.find("block.case"), std::string::npos) << nothing.error().message();
  const auto unknown = branchRun(runFolder(), {.step_began = second_began_ + 1}, branch);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, Error::Code::kNotFound);
  EXPECT_FALSE(fs::exists(branch));

  fs::create_directory(branch);
  EXPECT_FALSE(branchRun(runFolder(), {.sample = first_ended_}, branch)) << "it is there";
  EXPECT_TRUE(fs::is_empty(branch));
  fs::remove(branch);
}

}  // namespace
}  // namespace kerf::run_branch_test
