// Sessions with a neighbour beside the work object.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "geometry/mesh/mesh_check.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "tests/sim/person_at_mouse.h"

namespace kerf::live_neighbours_test {
namespace {

namespace fs = std::filesystem;
using test::bakedBlock;
using test::Mouse;
using test::someTools;

// Two blocks with a gap of 0.3 mm: one ends at x = 3, the other begins at 3.3. A bur of 1.4 mm at x = 2.9 cuts both.
const Vec3d kShift{6.3, 0, 0};
const Vec3d kBetween{2.9, 0, 0}, kMiddle{-1, 0, 0}, kOnNeighbour{6, 0, 0};

LiveRunOptions beside(const fs::path& neighbour) {
  LiveRunOptions out = someTools();
  out.beside.push_back({neighbour, "35"});
  return out;
}

double removedOff(LiveRun& run, std::uint32_t loaded) {
  run.thread().update();
  const HapticReport& report = run.thread().report();
  double out = 0;
  for (std::size_t n = 0; n < report.object_count; ++n)
    if (report.objects[n].loaded == loaded) out += report.objects[n].removed_mm3;
  return out;
}

class LiveNeighbours : public testing::Test {
 protected:
  TemporaryFolder folder_;
  const fs::path block_ = bakedBlock(folder_), other_ = bakedBlock(folder_, "other", kShift);
  const fs::path run_folder_ = folder_.path() / "block.run";
};

TEST_F(LiveNeighbours, ACutBetweenTwoIsRecordedOffBothReplaysAndExports) {
  auto run = LiveRun::open(block_, run_folder_, beside(other_));
  ASSERT_TRUE(run) << run.error().message();
  ASSERT_EQ((*run)->neighbours().size(), 1u);
  EXPECT_EQ((*run)->neighbours()[0].known.name, "35");
  double live_volume = 0;
  {
    Mouse mouse(**run);
    mouse.drill(kMiddle, 2);
    EXPECT_GT(removedOff(**run, 0), 0.05);
    EXPECT_EQ(removedOff(**run, 1), 0) << "3 mm away";
    const double before = removedOff(**run, 0);

    // One stroke in both is one step of undo.
    mouse.drill(kBetween, 3);
    const double off_other = removedOff(**run, 1), off_block = removedOff(**run, 0);
    EXPECT_GT(off_other, 0.01);
    EXPECT_GT(off_block, before + 0.01);
    mouse.send(Undo{});
    EXPECT_EQ(removedOff(**run, 1), 0);
    EXPECT_EQ(removedOff(**run, 0), before);
    mouse.send(Redo{});
    EXPECT_EQ(removedOff(**run, 1), off_other);
    EXPECT_EQ(removedOff(**run, 0), off_block);

    // Current state of either object.
    mouse.awaitMeshers();
    const auto view = (*run)->viewScene();
    ASSERT_TRUE(view);
    ASSERT_EQ(view->objects.size(), 2u);
    EXPECT_EQ(view->objects[1].name, "35");
    const auto scene = LiveRun::copyOf(*view);
    ASSERT_TRUE(scene) << scene.error().message();
    const auto mesh = (*run)->postOperative(*scene), neighbour = (*run)->postOperative(*scene, {}, {}, 1);
    ASSERT_TRUE(mesh) << mesh.error().message();
    ASSERT_TRUE(neighbour) << neighbour.error().message();
    EXPECT_TRUE(mesh->pieces.empty());
    EXPECT_NEAR(mesh->post_op.report.removed_volume_mm3, off_block, 0.15 * off_block);
    EXPECT_NEAR(neighbour->post_op.report.removed_volume_mm3, off_other, 0.3 * off_other);
    live_volume = neighbour->post_op.report.removed_volume_mm3;
    EXPECT_GT(bounds(neighbour->post_op.mesh).min[0], 3.2);
    EXPECT_FALSE((*run)->postOperative(*scene, {}, {}, 2)) << "there is no second neighbour";

    const auto manifest = (*run)->finish();
    ASSERT_TRUE(manifest) << manifest.error().message();
    ASSERT_EQ(manifest->beside.size(), 1u);
    EXPECT_EQ(manifest->beside[0].removed_mm3, off_other);
    EXPECT_EQ(manifest->beside[0].name, "35");
    EXPECT_TRUE(manifest->pieces.empty()) << "a neighbour is no piece";
  }
  run->reset();

  const auto replayed = replayRun(run_folder_);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_EQ(replayed->objects, 2u);
  EXPECT_TRUE(exportBundle(run_folder_));
  const auto exported = exportBundle(run_folder_, {}, {}, 1);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_TRUE(checkMesh(exported->post_op.mesh).print_ready);
  EXPECT_EQ(exported->post_op.report.removed_volume_mm3, live_volume)
      << "the same mesh, bricks that undo brought back or not";
  EXPECT_FALSE(exportBundle(run_folder_, {}, {}, 2));
}

TEST_F(LiveNeighbours, ASessionInWhichOnlyTheNeighbourWasCutIsKept) {
  auto run = LiveRun::open(block_, run_folder_, beside(other_));
  ASSERT_TRUE(run) << run.error().message();
  {
    Mouse mouse(**run);
    mouse.drill(kOnNeighbour, 3);
    const auto manifest = (*run)->finish();
    ASSERT_TRUE(manifest) << manifest.error().message();
    EXPECT_GT(manifest->beside[0].removed_mm3, 0.05);
  }
  run->reset();
  const auto exported = exportBundle(run_folder_);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->post_op.report.removed_volume_mm3, 0);
  EXPECT_GT(exportBundle(run_folder_, {}, {}, 1)->post_op.report.removed_volume_mm3, 0.05);
}

TEST_F(LiveNeighbours, AnotherSessionGoesOnWithThemAndTakesAFurtherOne) {
  {
    auto run = LiveRun::open(block_, run_folder_, beside(other_));
    ASSERT_TRUE(run) << run.error().message();
    Mouse mouse(**run);
    mouse.drill(kBetween, 3);
    ASSERT_TRUE((*run)->finish());
  }
  const double before = readRunManifest(run_folder_)->beside[0].removed_mm3;
  const double exported_before = exportBundle(run_folder_, {}, {}, 1)->post_op.report.removed_volume_mm3;
  ASSERT_GT(before, 0.01);

  const fs::path second_folder = folder_.path() / "second.run";
  LiveRunOptions options = someTools();
  options.from = run_folder_;
  options.beside.push_back({bakedBlock(folder_, "third", {-6.3, 0, 0}), "37"});
  {
    auto run = LiveRun::open(block_, second_folder, options);
    ASSERT_TRUE(run) << run.error().message();
    ASSERT_EQ((*run)->neighbours().size(), 2u);
    EXPECT_EQ((*run)->neighbours()[0].known.name, "35");
    EXPECT_EQ((*run)->neighbours()[0].known.removed_mm3, before);
    Mouse mouse(**run);
    mouse.drill({-2.9, 0, 0}, 3);
    mouse.drill({2.9, 1.5, 0}, 3);
    const auto manifest = (*run)->finish();
    ASSERT_TRUE(manifest) << manifest.error().message();
  }
  const auto manifest = readRunManifest(second_folder);
  ASSERT_TRUE(manifest) << manifest.error().message();
  ASSERT_EQ(manifest->beside.size(), 2u);
  EXPECT_GT(manifest->beside[0].removed_mm3, before + 0.01);
  EXPECT_GT(manifest->beside[1].removed_mm3, 0.01);
  const auto replayed = replayRun(second_folder);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  const auto exported = exportBundle(second_folder, {}, {}, 1);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_GT(exported->post_op.report.removed_volume_mm3, exported_before + 0.01) << "both cuts";
  EXPECT_TRUE(exportBundle(second_folder, {}, {}, 2));
}

TEST_F(LiveNeighbours, OneThatIsInTheSceneAlreadyIsRefused) {
  for (const fs::path& twice : {block_, other_}) {
    LiveRunOptions options = beside(other_);
    options.beside.push_back({twice, "again"});
    const auto run = LiveRun::open(block_, run_folder_, options);
    ASSERT_FALSE(run);
    EXPECT_NE(run.error().message().find("two solids in one place"), std::string::npos) << run.error().message();
    EXPECT_FALSE(fs::exists(run_folder_));
  }
}

TEST(LiveNeighboursKilled, WhatWasCutOffThemIsRecovered) {
  const TemporaryFolder folder;
  const fs::path run_folder = folder.path() / "block.run";
  const pid_t child = ::fork();  // before any thread starts
  ASSERT_GE(child, 0);
  if (child == 0) {
    const fs::path block = bakedBlock(folder), other = bakedBlock(folder, "other", kShift);
    auto run = LiveRun::open(block, run_folder, beside(other));
    if (!run) ::_exit(1);
    Mouse mouse(**run);
    mouse.drill(kBetween, 3);
    mouse.drill(kMiddle, 1.5);
    ::raise(SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << status;

  const auto recovered = recoverRun(run_folder);
  ASSERT_TRUE(recovered) << recovered.error().message();
  EXPECT_TRUE(recovered->replay.is_same) << recovered->replay.note;
  ASSERT_EQ(recovered->manifest.beside.size(), 1u);
  EXPECT_GT(recovered->manifest.beside[0].removed_mm3, 0.01);
  const auto again = replayRun(run_folder);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same) << again->note;
  EXPECT_TRUE(exportBundle(run_folder));
  EXPECT_TRUE(exportBundle(run_folder, {}, {}, 1));
}

}  // namespace
}  // namespace kerf::live_neighbours_test
