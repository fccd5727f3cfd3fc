#include "sim/run/session/live_run.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "sim/monitor/structures.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "sim/run/report/run_report.h"
#include "sim/run/session/run_branch.h"
#include "tests/sim/person_at_mouse.h"

namespace kerf::live_run_test {
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
  // Bricks changed by a stroke and restored by undo are also among the mesher's bricks, with their loaded values.
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

TEST(LiveRun, TheLoopRestsBesideAnIdleMouseAndLeavesOutNoTick) {
  const TemporaryFolder folder;
  const fs::path run_folder = folder.path() / "block.run";
  auto run = LiveRun::open(bakedBlock(folder), run_folder, someTools());
  ASSERT_TRUE(run) << run.error().message();
  constexpr std::uint64_t kIdle = 6000;  // the drive runs down first
  {
    Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 0.5);
    (*run)->thread().update();
    const std::uint64_t from = (*run)->thread().report().tick;
    EXPECT_TRUE(test::becomes((*run)->thread(), [&](const HapticReport& r) { return r.tick >= from + kIdle; }));
    mouse.drill({1, 0, 0}, 0.5);
    const auto manifest = (*run)->finish();
    ASSERT_TRUE(manifest) << manifest.error().message();
    EXPECT_GT(manifest->duration_s, kTick * kIdle) << "its clock goes on";
  }
  (*run)->thread().updateTimes();
  (*run)->thread().update();
  const std::uint64_t ticks = (*run)->thread().report().counts.ticks;
  EXPECT_LT((*run)->thread().times().cost.count() + kIdle / 3, ticks) << "each burst is timed once";
  run->reset();
  const auto replayed = replayRun(run_folder);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same) << replayed->note;
  EXPECT_EQ(replayed->ticks, ticks);
  EXPECT_GT(replayed->removed_mm3, 0.02);
}

TEST(LiveRun, PeaksAreOfStrokesThatStandAndWorseOnesTakenBackAreToldApart) {
  const TemporaryFolder folder;
  const fs::path block = bakedBlock(folder), run_folder = folder.path() / "block.run";
  auto run = LiveRun::open(block, run_folder, someTools());
  ASSERT_TRUE(run) << run.error().message();
  const ToolSamples samples((*run)->model().tools[0].cut, kToolSamples);
  (*run)->thread().heatBy(0, samples, heatSource((*run)->tools()[0].tool));
  {
    Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 1, 5);
    mouse.send(Undo{});
    mouse.drill({1, 0, 0}, 1, 1);
    mouse.drill({-1, 0, 0}, 1, 6);
    mouse.send(Undo{});  // the last undo: nothing replaces it
    ASSERT_TRUE((*run)->finish());
  }
  run->reset();

  const auto kept = readRunReport(run_folder), replayed = readRunReport(run_folder, true);
  for (const auto* report : {&kept, &replayed}) {
    ASSERT_TRUE(*report) << report->error().message();
    const RunReport& r = **report;
    ASSERT_TRUE(r.contact_force && r.taken_back.contact_force && r.mean_contact_force);
    EXPECT_LT(r.contact_force->value, 3) << "of 1 N";
    EXPECT_GT(r.taken_back.contact_force->value, r.contact_force->value + 0.5) << "of 5 and 6 N";
    EXPECT_GT(*r.mean_contact_force, 0.3);
    EXPECT_LT(*r.mean_contact_force, 1.5);
    EXPECT_GT(r.removed_mm3.value_or(0), 0.05);
  }
  EXPECT_NEAR(kept->contact_force->value, replayed->contact_force->value, 1e-9);
  EXPECT_NEAR(kept->taken_back.contact_force->value, replayed->taken_back.contact_force->value, 1e-9);
  EXPECT_NEAR(*kept->mean_contact_force, *replayed->mean_contact_force, 1e-9);
  EXPECT_NEAR(kept->hottest->value, replayed->hottest->value, 0.01);
  EXPECT_EQ(kept->is_summary_edited, false);
}

TEST(LiveRun, WhatAKilledProgramLeavesIsRecovered) {
  const TemporaryFolder folder;
  const fs::path run_folder = folder.path() / "block.run";
  const pid_t child = ::fork();  // before any thread starts
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

// A hole is filled. The next day somebody drills in the filling, and the day after somebody continues from there.
TEST(LiveRun, AFillingIsOfItsMaterialInSessionsThatGoOn) {
  const TemporaryFolder folder;
  const fs::path block = bakedBlock(folder), first = folder.path() / "first.run", second = folder.path() / "second.run";
  constexpr auto kFilling = static_cast<std::uint8_t>(Material::kComposite);
  double added = 0, removed = 0, left = 0;
  {
    auto run = LiveRun::open(block, first, someTools());
    ASSERT_TRUE(run) << run.error().message();
    Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 2);
    mouse.send(AddMaterial{kFilling, 0});
    mouse.drill({-1, 0, 0}, 1);
    mouse.send(StopAdding{});
    const auto ended = (*run)->finish();
    ASSERT_TRUE(ended) << ended.error().message();
    const CutObject& object = (*run)->thread().session().state().objects.front();
    added = object.added_mm3[kFilling] - object.removed_mm3[kFilling];
    ASSERT_GT(added, 0.1);
  }
  const auto report = readRunReport(first, false, {});
  ASSERT_TRUE(report) << report.error().message();
  ASSERT_TRUE(report->added_by_material.contains("composite"));
  EXPECT_NEAR(report->added_by_material.at("composite"), added, 0.01 * added);
  EXPECT_GT(report->removed_mm3.value_or(0), 0.05) << "the hole, whatever fills it";

  LiveRunOptions options = someTools();
  options.from = first;
  {
    auto run = LiveRun::open(block, second, options);
    ASSERT_TRUE(run) << run.error().message();
    EXPECT_EQ((*run)->addedBefore(), 0) << "nothing is to be told";
    EXPECT_NEAR((*run)->object().volumes()[kFilling], added, 1e-6);
    EXPECT_NEAR((*run)->removedBefore(), *report->removed_mm3, 1e-6) << "a filling puts nothing back";
    Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 2);
    const auto ended = (*run)->finish();
    ASSERT_TRUE(ended) << ended.error().message();
    removed = (*run)->thread().session().state().objects.front().removed_mm3[kFilling];
    EXPECT_GT(removed, 0.05);
    left = added - removed;
  }
  const auto replayed = replayRun(second);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;

  // Its initial state as a separate run.
  const fs::path branch = folder.path() / "began.run";
  const auto began = branchRun(second, {.sample = 0}, branch);
  ASSERT_TRUE(began) << began.error().message();
  const auto of_first = readRunMaterials(first), of_branch = readRunMaterials(branch);
  ASSERT_TRUE(of_first && of_branch);
  EXPECT_EQ(of_branch->bricks, of_first->bricks);
  EXPECT_EQ(of_branch->numbers, of_first->numbers);

  // Its program is gone: recovery finishes it from its log.
  const auto before = readRunManifest(second);
  const auto materials = readRunMaterials(second);
  ASSERT_TRUE(before && materials);
  ASSERT_FALSE(materials->isEmpty());
  RunManifest open = *before;
  open.is_open = true;
  ASSERT_TRUE(writeRunManifest(second, open));
  fs::remove(second / "run.vdb");
  const auto recovered = recoverRun(second);
  ASSERT_TRUE(recovered) << recovered.error().message();
  EXPECT_EQ(recovered->manifest.state_hash, before->state_hash);
  const auto again = readRunMaterials(second);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->bricks, materials->bricks);
  EXPECT_EQ(again->numbers, materials->numbers);
  EXPECT_EQ(again->added, (std::map<std::uint8_t, std::string>{{kFilling, "composite"}}));

  options.from = second;
  const auto third = LiveRun::open(block, folder.path() / "third.run", options);
  ASSERT_TRUE(third) << third.error().message();
  EXPECT_EQ((*third)->addedBefore(), 0);
  EXPECT_NEAR((*third)->object().volumes()[kFilling], left, 1e-6);
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
}  // namespace kerf::live_run_test
