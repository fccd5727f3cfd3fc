#include "sim/run/live_run.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/bake/bake.h"
#include "sim/hand/mouse_hand.h"
#include "sim/run/export_bundle.h"
#include "sim/run/run_files.h"
#include "tests/sim/haptic_scene.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// A block of 6 x 4 x 3 mm, its top at z = 0, baked at 0.1 mm.
fs::path bakedBlock(const TemporaryFolder& folder) {
  const fs::path file = folder.path() / "block.ply", out = folder.path() / "block.case";
  EXPECT_TRUE(writeMesh(file, test::blockMesh(true)));
  BakeOptions options;
  options.unit = "mm";
  options.voxelize.voxel_mm = 0.1;
  const auto baked = bake({file}, out, options);
  EXPECT_TRUE(baked) << baked.error().message();
  return out;
}

LiveRunOptions someTools() {
  LiveRunOptions out;
  for (const char* id : {"round-014", "round-010"}) {
    const auto file = findToolFile(id, defaultToolFolders());
    EXPECT_TRUE(file) << file.error().message();
    out.tools.push_back({*file, *readTool(*file)});
  }
  out.start = {Eigen::Quaterniond::Identity(), {0, 0, 3}};
  out.haptic = test::ordinaryHaptics();
  out.mesher.remesher.is_parallel = false;
  return out;
}

// A person at the mouse.
class Mouse {
 public:
  explicit Mouse(LiveRun& run)
      : run_(run),
        hand_(surfaceOf(run), {Eigen::Quaterniond::Identity(), {0, 0, 3}}, run.model().settings.coupling.stiffness) {
    const auto started = run.start(hand_);
    EXPECT_TRUE(started) << started.error().message();
  }
  // Presses until something was removed, or the depth is reached.
  void drill(const Vec3d& at, double seconds) {
    ++aim_.stroke;
    aim_.is_pressed = true;
    aim_.anchor = aim_.pointer = at;
    aim_.force = 1.5;
    aim_.depth = 0.5;
    hand_.aim(aim_);
    EXPECT_TRUE(run_.send(PlaceTool{{at[0], at[1], at[2] + 0.3}}));
    waitFor(seconds);
    aim_.is_pressed = false;
    hand_.aim(aim_);
    waitFor(0.05);
  }
  void send(const Command& command) {
    EXPECT_TRUE(run_.send(command));
    waitFor(0.05);
  }

 private:
  static std::shared_ptr<const BrickField> surfaceOf(const LiveRun& run) { return run.original(); }
  // By the simulation's clock: the machine may be slow.
  void waitFor(double seconds) {
    run_.thread().update();
    const auto until = run_.thread().report().tick + static_cast<std::uint64_t>(seconds / kTick);
    EXPECT_TRUE(test::becomes(run_.thread(), [&](const HapticReport& r) { return r.tick >= until; }));
  }

  LiveRun& run_;
  MouseHand hand_;
  MouseAim aim_;
};

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
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
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
