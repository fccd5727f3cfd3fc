#include "sim/run/live_run.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "sim/run/export_bundle.h"
#include "sim/run/run_files.h"
#include "tests/sim/person_at_mouse.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using test::bakedBlock;
using test::Mouse;
using test::someTools;

TEST(LiveRun, StrokesWithTwoToolsBecomeARunThatReplaysAndExports) {
  const TemporaryFolder folder;
  const fs::path block = bakedBlock(folder), run_folder = folder.path() / "a" / "block.run";
  auto run = LiveRun::open(block, run_folder, someTools());
  ASSERT_TRUE(run) << run.error().message();
  BrickField now;
  {
    Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 3);
    mouse.send(SelectTool{1});
    mouse.drill({1, 0, 0}, 3);
    mouse.drill({1.5, 1, 0}, 3);
    mouse.send(Undo{});
    mouse.awaitMeshers();
    const auto view = (*run)->viewScene();
    ASSERT_TRUE(view);
    const auto scene = LiveRun::copyOf(*view);
    ASSERT_TRUE(scene) << scene.error().message();
    ASSERT_EQ(scene->objects.size(), 1u);
    const auto mesh = (*run)->postOperative(*scene);
    ASSERT_TRUE(mesh) << mesh.error().message();
    EXPECT_GT(mesh->post_op.report.removed_volume_mm3, 0.1);
    EXPECT_TRUE(mesh->pieces.empty());
    now = scene->objects.front().changed;
    const auto manifest = (*run)->finish();
    ASSERT_TRUE(manifest) << manifest.error().message();
    EXPECT_EQ(manifest->tool_id, "round-014, round-010");
  }
  run->reset();

  const auto manifest = readRunManifest(run_folder);
  ASSERT_TRUE(manifest) << manifest.error().message();
  EXPECT_FALSE(manifest->is_open);
  EXPECT_EQ(manifest->tools.size(), 2u);
  const auto changed = readRunCutField(run_folder);
  ASSERT_TRUE(changed) << changed.error().message();
  // What a stroke changed and undo brought back is among the mesher's bricks, too: as it was loaded.
  EXPECT_GE(now.brickCount(), changed->brickCount());
  for (std::size_t b = 0; b < changed->brickCount(); ++b) {
    const BrickValues* const known = now.valuesAt(changed->brickCoord(b));
    ASSERT_TRUE(known && *known == changed->brick(b));
  }

  const auto replayed = replayRun(run_folder);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same) << replayed->note;
  EXPECT_TRUE(replayed->is_whole) << replayed->note;
  EXPECT_GE(replayed->commands, 5u);
  const auto exported = exportBundle(run_folder);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_GT(exported->post_op.report.removed_volume_mm3, 0.1);
  EXPECT_FALSE(recoverRun(run_folder)) << "it was ended";
}

TEST(LiveRun, WhatAKilledProgramLeavesIsRecovered) {
  const TemporaryFolder folder;
  const fs::path run_folder = folder.path() / "block.run";
  const pid_t child = ::fork();  // before any thread is made
  ASSERT_GE(child, 0);
  if (child == 0) {
    const fs::path block = bakedBlock(folder);
    auto run = LiveRun::open(block, run_folder, someTools());
    if (!run) ::_exit(1);
    Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 3);
    mouse.drill({1, 0, 0}, 1.5);
    ::raise(SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << status;

  const auto refused = exportBundle(run_folder);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().hint.find("kerf recover"), std::string::npos) << refused.error().message();
  const auto recovered = recoverRun(run_folder);
  ASSERT_TRUE(recovered) << recovered.error().message();
  EXPECT_TRUE(recovered->replay.is_same) << recovered->replay.note;
  EXPECT_GT(recovered->manifest.duration_s, 3.5) << "at most a second is lost";
  EXPECT_GT(recovered->replay.removed_mm3, 0.1);
  const auto again = replayRun(run_folder);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same) << again->note;
  EXPECT_TRUE(exportBundle(run_folder));
}

TEST(LiveRun, NothingCutLeavesNoFolder) {
  const TemporaryFolder folder;
  const fs::path block = bakedBlock(folder), run_folder = folder.path() / "block.run";
  auto run = LiveRun::open(block, run_folder, someTools());
  ASSERT_TRUE(run) << run.error().message();
  EXPECT_TRUE(isRun(run_folder));
  const auto open_elsewhere = recoverRun(run_folder);
  ASSERT_FALSE(open_elsewhere);
  EXPECT_NE(open_elsewhere.error().found.find("open in another program"), std::string::npos);
  {
    Mouse mouse(**run);
    mouse.send(SelectTool{1});
    const auto ended = (*run)->finish();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, Error::Code::kEmpty);
  }
  EXPECT_FALSE(fs::exists(run_folder));
}

TEST(LiveRun, OneThatWasNeverStartedLeavesNoFolder) {
  const TemporaryFolder folder;
  const fs::path block = bakedBlock(folder), run_folder = folder.path() / "block.run";
  auto run = LiveRun::open(block, run_folder, someTools());
  ASSERT_TRUE(run) << run.error().message();
  EXPECT_TRUE(isRun(run_folder));
  run->reset();
  EXPECT_FALSE(fs::exists(run_folder));
}

TEST(LiveRun, AFolderThatIsThereIsLeftAlone) {
  const TemporaryFolder folder;
  const fs::path block = bakedBlock(folder);
  const auto run = LiveRun::open(block, block, someTools());
  ASSERT_FALSE(run);
  EXPECT_TRUE(isCase(block));
}

}  // namespace
}  // namespace kerf
