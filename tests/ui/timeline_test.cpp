#include "ui/app/session/timeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <thread>

#include "geometry/formats/mesh_writer.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/report/replay.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/document/document.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/jobs.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/tool_monitor.h"

namespace kerf::timeline_test {
namespace {

namespace fs = std::filesystem;

UndoStep strokeOf(std::uint64_t number) {
  return {number, {1000 * number, 2}, UndoStep::Kind::kStroke, 0.1 * static_cast<double>(number), 0};
}

// In the form of SessionHistory.
UndoList listOf(const std::vector<UndoStep>& all, std::size_t undoable, std::uint64_t forgotten = 0) {
  UndoList out;
  out.undoable = undoable;
  out.redoable = all.size() - undoable;
  out.forgotten = forgotten;
  out.newest_count = std::min(all.size(), UndoList::kMostNewest);
  std::copy(all.end() - static_cast<std::ptrdiff_t>(out.newest_count), all.end(), out.newest.begin());
  return out;
}

std::vector<UndoStep> strokes(std::uint64_t first, std::uint64_t last) {
  std::vector<UndoStep> out;
  for (std::uint64_t n = first; n <= last; ++n) out.push_back(strokeOf(n));
  return out;
}

double removedBy(const Timeline& timeline) {
  double sum = 0;
  for (const TimelineStep& step : timeline.steps()) sum += step.removed_mm3;
  return sum;
}

TEST(Timeline, KeepsStepsThatAReportNoLongerNames) {
  Timeline timeline;
  for (std::uint64_t n = 1; n <= 20; ++n) timeline.update(listOf(strokes(1, n), n));
  ASSERT_EQ(timeline.steps().size(), 20u);
  EXPECT_EQ(timeline.done(), 20u);
  EXPECT_NEAR(removedBy(timeline), 21, 1e-9);
  EXPECT_EQ(timeline.steps()[3].began_s, 4);
  EXPECT_EQ(timeline.steps()[3].tool, 2u);

  // Undone, and another stroke from there.
  timeline.update(listOf(strokes(1, 20), 5));
  EXPECT_EQ(timeline.done(), 5u);
  EXPECT_EQ(timeline.steps().size(), 20u);
  std::vector<UndoStep> branch = strokes(1, 5);
  branch.push_back(strokeOf(21));
  timeline.update(listOf(branch, 6));
  ASSERT_EQ(timeline.steps().size(), 6u);
  EXPECT_NEAR(removedBy(timeline), 1.5 + 2.1, 1e-9);
  EXPECT_EQ(timeline.older(), 0u);
}

TEST(Timeline, CountsStepsThatWereTooManyForAReport) {
  Timeline timeline;
  timeline.update(listOf(strokes(1, 3), 3));
  timeline.update(listOf(strokes(1, 15), 15));
  EXPECT_EQ(timeline.steps().size(), 15u);
  EXPECT_NEAR(timeline.steps()[14].removed_mm3, 1.5, 1e-9);

  // Replaces undone strokes, all between two reports.
  timeline.update(listOf(strokes(1, 15), 12));
  std::vector<UndoStep> branch = strokes(1, 12);
  for (std::uint64_t n = 16; n < 24; ++n) branch.push_back(strokeOf(n));
  timeline.update(listOf(branch, 20));
  ASSERT_EQ(timeline.steps().size(), 20u);
  EXPECT_EQ(timeline.steps()[5].removed_mm3, 0) << "nobody saw it";
  EXPECT_NEAR(timeline.steps()[11].removed_mm3, 1.2, 1e-9);
  EXPECT_NEAR(timeline.steps()[12].removed_mm3, 1.6, 1e-9);
}

TEST(Timeline, NumbersGoOnWhenTheOldestAreForgotten) {
  Timeline timeline;
  timeline.update(listOf(strokes(1, 6), 6));
  timeline.update(listOf(strokes(3, 8), 6, 2));
  EXPECT_EQ(timeline.older(), 2u);
  ASSERT_EQ(timeline.steps().size(), 6u);
  EXPECT_NEAR(timeline.steps()[0].removed_mm3, 0.3, 1e-9);

  EXPECT_EQ(timeline.strokesAfter(2), 0u);
  EXPECT_EQ(timeline.strokesAfter(8), 6u);
  const auto too_old = timeline.strokesAfter(1), too_far = timeline.strokesAfter(9);
  ASSERT_FALSE(too_old || too_far);
  EXPECT_EQ(too_old.error().code, Error::Code::kUnsupported);
  EXPECT_NE(too_old.error().message().find("no longer stored"), std::string::npos) << too_old.error().message();
  EXPECT_NE(too_far.error().message().find("2 to 8"), std::string::npos) << too_far.error().message();
}

TEST(Timeline, APlannedCutIsOneStepHoweverManyStrokesItTook) {
  Timeline timeline;
  timeline.update(listOf(strokes(1, 2), 2));
  timeline.beginPlannedCut("mesial");
  timeline.update(listOf(strokes(1, 3), 3));
  timeline.update(listOf(strokes(1, 5), 5));
  timeline.endPlannedCut();
  timeline.update(listOf(strokes(1, 6), 6));
  ASSERT_EQ(timeline.steps().size(), 4u);
  const TimelineStep& cut = timeline.steps()[2];
  EXPECT_EQ(cut.kind, TimelineStep::Kind::kPlannedCut);
  EXPECT_EQ(cut.plane, "mesial");
  EXPECT_EQ(cut.strokes, 3u);
  EXPECT_NEAR(cut.removed_mm3, 1.2, 1e-9);
  EXPECT_EQ(describeStep(cut, 3, "saw"), "3: planned cut mesial, 1.20 mm3 removed, at 3.0 s");
  EXPECT_EQ(timeline.strokesAt(3), 5u);
  EXPECT_EQ(timeline.doneAt(5), 3u);
  EXPECT_EQ(timeline.doneAt(4), 2u) << "a part of it is not all of it";

  // No cut: the next stroke is separate.
  timeline.beginPlannedCut("distal");
  timeline.endPlannedCut();
  timeline.update(listOf(strokes(1, 7), 7));
  EXPECT_EQ(timeline.steps().back().kind, TimelineStep::Kind::kStroke);
}

TEST(Timeline, AHoleAndADeletionAreNamed) {
  Timeline timeline;
  timeline.beginPlannedCut("hole 1");
  timeline.update(listOf(strokes(1, 2), 2));
  timeline.endPlannedCut("hole 1, 2.0 mm wide, 9.8 mm deep");
  std::vector<UndoStep> steps = strokes(1, 3);
  steps.back().kind = UndoStep::Kind::kDelete;
  steps.back().deleted = 2;
  timeline.update(listOf(steps, 3));
  ASSERT_EQ(timeline.steps().size(), 2u);
  EXPECT_EQ(describeStep(timeline.steps()[0], 1, "drill"),
            "1: hole 1, 2.0 mm wide, 9.8 mm deep, 0.30 mm3 removed, at 1.0 s");
  EXPECT_EQ(timeline.steps()[1].kind, TimelineStep::Kind::kDelete);
  EXPECT_EQ(describeStep(timeline.steps()[1], 2, "drill"), "2: 2 pieces deleted, 0.30 mm3, at 3.0 s");
}

TEST(Timeline, StepsInWhosePlaceOthersCameAreABranch) {
  Timeline timeline;
  timeline.update(listOf(strokes(1, 5), 5));
  EXPECT_FALSE(timeline.ahead(timeline.strokesDone()));
  timeline.update(listOf(strokes(1, 5), 2));
  const auto ahead = timeline.ahead(timeline.strokesDone());
  ASSERT_TRUE(ahead);
  EXPECT_EQ(ahead->steps.size(), 3u);
  timeline.update(listOf(strokes(1, 5), 4));
  timeline.update(listOf(strokes(1, 5), 2));
  EXPECT_TRUE(timeline.branches().empty()) << "they can be done again";

  std::vector<UndoStep> line = strokes(1, 2);
  line.push_back(strokeOf(6));
  timeline.update(listOf(line, 3));
  ASSERT_EQ(timeline.branches().size(), 1u);
  const TimelineBranch& branch = timeline.branches()[0];
  EXPECT_EQ(branch.from, 2u);
  EXPECT_EQ(branch.last_began, 5000u);
  ASSERT_EQ(branch.steps.size(), 3u);
  EXPECT_EQ(branch.steps[0].began_s, 3);
  EXPECT_EQ(describeBranch(branch), "from step 2: 3 steps, 1.20 mm3 removed, the last at 5.0 s");

  // Undone and replaced between two reports; the stroke continues.
  line = {strokeOf(7)};
  timeline.update(listOf(line, 1));
  line[0].removed_mm3 += 1;
  timeline.update(listOf(line, 1));
  ASSERT_EQ(timeline.branches().size(), 2u);
  EXPECT_EQ(timeline.branches()[1].from, 0u);
  EXPECT_EQ(timeline.branches()[1].last_began, 6000u);
  EXPECT_EQ(timeline.branches()[1].steps.size(), 3u);
  timeline.clear();
  EXPECT_TRUE(timeline.branches().empty());
}

TEST(Timeline, StepsThatAreTooOldOrTooManyForAReportAreNoBranch) {
  Timeline timeline;
  timeline.update(listOf(strokes(1, 6), 6));
  timeline.update(listOf(strokes(3, 8), 6, 2));
  timeline.update(listOf(strokes(3, 30), 28, 2));
  EXPECT_TRUE(timeline.branches().empty());
}

TEST(Timeline, WhatANewStrokeWouldDropIsSaidIfItIsMoreThanOneStep) {
  EXPECT_EQ(lossOf(0), "");
  EXPECT_EQ(lossOf(1), "");
  EXPECT_NE(lossOf(7).find("7 steps"), std::string::npos);
}

// ---- A session

class TimelineTest : public testing::Test {
 protected:
  TimelineTest() {
    WorkbenchOptions options;
    options.data_folder = folder_.path() / "data";
    options.tools = {"round-014", "round-010", "saw-reciprocating-25"};
    options.real_time = {.priority = 0, .lock_memory = false};
    bench_.emplace(options);
    context_.emplace(AppContext{.bench = *bench_, .camera = camera_, .width = 400, .height = 300});
    const fs::path file = folder_.path() / "a scan.ply";
    EXPECT_TRUE(writeMesh(file, test::blockMesh(false)));
    run("file.open \"" + file.string() + "\"\nwait\nview.fit\ncut.force 2\ncut.depth 0.4\n");
  }
  void run(const std::string& script) {
    const auto played = runScript(*context_, folder_.write("script.ks", script), [&] { bench_->update(); });
    EXPECT_TRUE(played) << played.error().message();
  }
  std::string refusalOf(const std::string& script) {
    const auto played = runScript(*context_, folder_.write("script.ks", script), [&] { bench_->update(); });
    return played ? "" : played.error().message();
  }
  void stroke(int x) { run("cut.press " + std::to_string(x) + " 150\nwait 1\ncut.release\nwait 0.2\n"); }
  void goTo(std::size_t step) { run("edit.go " + std::to_string(step) + "\nwait 0.3\n"); }
  fs::path end() {
    bench_->sessions->close();
    while (bench_->jobs->running()) bench_->update();
    return bench_->document->sessionFolder();
  }

  TemporaryFolder folder_;
  std::optional<Workbench> bench_;
  Camera camera_ = *cameraFromView("top");
  std::optional<AppContext> context_;
};

TEST_F(TimelineTest, GoesBackAndForwardAndBranchesAndTheLogReplays) {
  std::vector<double> removed{0};
  for (const int x : {150, 180, 210, 240}) {
    stroke(x);
    removed.push_back(bench_->document->removedMm3());
    ASSERT_GT(removed.back(), removed[removed.size() - 2]);
  }
  run("expect steps 4 4\nexpect ahead 0 0\n");
  for (std::size_t n = 0; n < 4; ++n)
    EXPECT_NEAR(bench_->steps->timeline().steps()[n].removed_mm3, removed[n + 1] - removed[n], 1e-9);

  for (const std::size_t step : {1u, 3u, 0u, 4u, 2u}) {
    goTo(step);
    EXPECT_NEAR(bench_->document->removedMm3(), removed[step], 1e-9) << step;
    EXPECT_EQ(bench_->steps->timeline().done(), step);
  }
  run("edit.begin\nwait 0.3\nexpect steps 0 0\nexpect ahead 4 4\nedit.end\nwait 0.3\nexpect steps 4 4\n");
  EXPECT_NEAR(bench_->document->removedMm3(), removed[4], 1e-9);

  // Another stroke from the second step replaces the two steps ahead of it.
  run("tool.select round-010\nedit.go 2\nwait 0.3\nexpect branches 0 0\n");
  stroke(260);
  run("expect steps 3 3\nexpect ahead 0 0\nexpect branches 1 1\n");
  EXPECT_EQ(bench_->steps->timeline().steps()[2].tool, 1u);
  EXPECT_NE(refusalOf("edit.go 4\n").find("0 to 3"), std::string::npos);
  EXPECT_NE(refusalOf("edit.go 1.5\n").find("whole"), std::string::npos);

  const double at_the_end = bench_->document->removedMm3();
  const auto replayed = replayRun(end());
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_NEAR(replayed->removed_mm3, at_the_end, 1e-6);
}

TEST_F(TimelineTest, ABranchIsGoneOnWithAndTheLineThatWasLeftIsOneThen) {
  std::vector<double> removed{0};
  for (const int x : {150, 180, 210}) {
    stroke(x);
    removed.push_back(bench_->document->removedMm3());
  }
  goTo(1);
  stroke(260);
  const double other = bench_->document->removedMm3();
  ASSERT_GT(std::abs(other - removed[3]), 1e-3);
  ASSERT_EQ(bench_->steps->branchCount(), 1u);
  EXPECT_NE(bench_->steps->branches()[0].text.find("from step 1: 2 steps"), std::string::npos)
      << bench_->steps->branches()[0].text;
  EXPECT_NE(refusalOf("edit.branch 2\n").find("1 to 1"), std::string::npos);
  const fs::path left = bench_->document->sessionFolder();

  run("edit.branch 1\nwait\nexpect steps 0 0\nexpect branches 1 1\n");
  EXPECT_NEAR(bench_->document->removedMm3(), removed[3], 1e-6);
  EXPECT_NE(bench_->document->sessionFolder(), left);
  const auto of_left = replayRun(left);
  ASSERT_TRUE(of_left) << of_left.error().message();
  EXPECT_TRUE(of_left->is_same && of_left->is_whole) << of_left->note;
  EXPECT_NEAR(of_left->removed_mm3, other, 1e-6);

  // To and fro: only a session with a stroke is kept.
  run("edit.branch\nwait\nexpect branches 1 1\n");
  EXPECT_NEAR(bench_->document->removedMm3(), other, 1e-6);
  run("edit.branch\nwait\nexpect branches 1 1\n");
  EXPECT_NEAR(bench_->document->removedMm3(), removed[3], 1e-6);
  stroke(240);
  const double more = bench_->document->removedMm3();
  ASSERT_GT(more, removed[3] + 1e-3);
  run("edit.branch 1\nwait\nexpect branches 1 1\nedit.branch 1\nwait\nexpect steps 0 0\n");
  EXPECT_NEAR(bench_->document->removedMm3(), more, 1e-6);

  stroke(150);
  const fs::path last = end();
  const auto replayed = replayRun(last);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  for (const auto& folder : fs::directory_iterator(folder_.path() / "data" / "sessions"))
    EXPECT_FALSE(readRunManifest(folder.path())->is_open) << folder.path();
}

// The log of an empty session is deleted, but not its undone strokes.
TEST_F(TimelineTest, WhatWasTakenBackIsKeptOfASessionInWhichNothingIsLeft) {
  stroke(150);
  const double first = bench_->document->removedMm3();
  goTo(0);
  stroke(210);
  stroke(240);
  const double second = bench_->document->removedMm3();
  goTo(0);
  const fs::path empty = bench_->document->sessionFolder();
  run("edit.branch 1\nwait\nexpect branches 1 1\n");
  EXPECT_NEAR(bench_->document->removedMm3(), first, 1e-6);
  EXPECT_FALSE(fs::exists(empty));
  run("edit.branch 1\nwait\nexpect branches 1 1\n");
  EXPECT_NEAR(bench_->document->removedMm3(), second, 1e-6);

  // The same at the end of the session.
  stroke(150);
  goTo(0);
  stroke(180);
  goTo(0);
  const fs::path gone = end();
  EXPECT_FALSE(fs::exists(gone));
  const std::string told = bench_->notices->list().back().text;
  ASSERT_NE(told.find("are kept:\n"), std::string::npos) << told;
  const fs::path kept = told.substr(told.rfind('\n') + 1);
  const auto replayed = replayRun(kept);
  ASSERT_TRUE(replayed) << kept << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_GT(replayed->removed_mm3, 0.01);
}

// The folder as left by a killed program.
TEST_F(TimelineTest, WhatWasTakenBackIsKeptOfALostSessionInWhichNothingIsLeft) {
  stroke(150);
  const double first = bench_->document->removedMm3();
  goTo(0);
  stroke(210);
  const double second = bench_->document->removedMm3();
  goTo(0);
  run("wait 3\n");  // until the log is on the disk
  const fs::path sessions = folder_.path() / "data" / "sessions", lost = sessions / "lost.run";
  fs::copy(bench_->document->sessionFolder(), lost, fs::copy_options::recursive);
  end();

  WorkbenchOptions options;
  options.data_folder = folder_.path() / "data";
  options.tools = {"round-014"};
  Workbench next(options);
  ASSERT_EQ(next.history->lostSessions().size(), 1u);
  next.history->recover(0);
  while (next.jobs->running()) next.update();
  EXPECT_FALSE(fs::exists(lost));
  EXPECT_TRUE(next.history->lostSessions().empty());
  EXPECT_NE(next.notices->list().back().text.find("are kept:\n"), std::string::npos)
      << next.notices->list().back().text;
  std::vector<double> removed;
  for (const auto& entry : fs::directory_iterator(sessions)) {
    if (next.notices->list().back().text.find(entry.path().string()) == std::string::npos) continue;
    const auto replayed = replayRun(entry.path());
    ASSERT_TRUE(replayed) << replayed.error().message();
    removed.push_back(replayed->removed_mm3);
  }
  std::sort(removed.begin(), removed.end());
  ASSERT_EQ(removed.size(), 2u);
  EXPECT_NEAR(removed[0], std::min(first, second), 1e-6);
  EXPECT_NEAR(removed[1], std::max(first, second), 1e-6);
}

TEST_F(TimelineTest, ASessionThatIsWatchedIsGoneOnWithFromAnyMoment) {
  std::vector<double> removed{0};
  for (const int x : {150, 180, 210}) {
    stroke(x);
    removed.push_back(bench_->document->removedMm3());
  }
  const fs::path whole = end();
  run("replay.open \"" + whole.string() + "\"\nwait\n");
  run("replay.time 1.35\nwait\n");
  const double at = bench_->document->removedMm3();
  ASSERT_GT(at, 0.01);
  run("replay.go-on\nwait\nexpect steps 0 0\n");
  ASSERT_TRUE(bench_->document->isOpen());
  EXPECT_NEAR(bench_->document->removedMm3(), at, 1e-6);
  stroke(240);
  ASSERT_GT(bench_->document->removedMm3(), at + 1e-3);

  const double now = bench_->document->removedMm3();
  const fs::path session = end();
  const auto replayed = replayRun(session);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_NEAR(at + replayed->removed_mm3, now, 1e-6);
  EXPECT_NEAR(replayRun(whole)->removed_mm3, removed[3], 1e-6) << "what is gone on with is never changed";

  // A continued run has earlier changes before its first stroke, too. They are kept once, for any number of requests.
  const auto runs = [&] {
    const fs::directory_iterator all(folder_.path() / "data" / "sessions");
    return std::distance(fs::begin(all), fs::end(all));
  };
  run("replay.open \"" + session.string() + "\"\nwait\nreplay.time 0.01\nwait\nreplay.go-on\nwait\n");
  ASSERT_TRUE(bench_->document->isOpen());
  EXPECT_NEAR(bench_->document->removedMm3(), at, 1e-6);
  end();
  const auto kept = runs();
  run("replay.open \"" + session.string() + "\"\nwait\nreplay.time 0.01\nwait\nreplay.go-on\nwait\n");
  ASSERT_TRUE(bench_->document->isOpen());
  end();
  EXPECT_EQ(runs(), kept);

  // At the beginning of a run from a case there is nothing to continue; error notices end a script.
  run("replay.open \"" + whole.string() + "\"\nwait\n");
  EXPECT_NE(refusalOf("replay.go-on\nwait\n").find("nothing is cut up to there"), std::string::npos);
  EXPECT_TRUE(bench_->document->watched());
}

// A branch exists to be continued: otherwise it is not kept.
TEST_F(TimelineTest, ABranchThatCanNotBeOpenedIsNotKept) {
  stroke(150);
  const fs::path session = end();
  OpeningOptions options;
  options.data_folder = folder_.path() / "data";
  const auto opened = openBranchToCut(session, {.sample = 1000}, options);
  ASSERT_FALSE(opened) << "a rack without tools cuts nothing";
  EXPECT_EQ(opened.error().place, "tools") << opened.error().message();
  const fs::directory_iterator all(session.parent_path());
  EXPECT_EQ(std::distance(fs::begin(all), fs::end(all)), 1);
}

TEST_F(TimelineTest, WhatIsFeltAndCutIsTraced) {
  using Channel = Trace::Channel;
  EXPECT_EQ(bench_->monitor->trace().largest(Channel::kRate), 0);
  stroke(200);
  const Trace& trace = bench_->monitor->trace();
  EXPECT_GT(trace.largest(Channel::kForce), 0.5);
  EXPECT_LT(trace.largest(Channel::kForce), 8);
  EXPECT_GT(trace.largest(Channel::kSpindle), 10);  // its remaining speed depends on the time of contact
  EXPECT_LT(trace.largest(Channel::kSpindle), 110);
  EXPECT_GT(trace.largest(Channel::kDepth), 0.05);
  double cut = 0;
  for (const float rate : trace.values(Channel::kRate)) cut += static_cast<double>(rate) / Trace::kPerSecond;
  EXPECT_NEAR(cut, bench_->document->removedMm3(), 0.3 * bench_->document->removedMm3());

  const float most = trace.largest(Channel::kRate);
  run("edit.undo\nwait 0.3\nedit.redo\nwait 0.3\n");
  EXPECT_EQ(trace.largest(Channel::kRate), most) << "what comes back is no cut";

  run("view.plots on\n");
  EXPECT_TRUE(context_->panels["plots"]);
  run("view.plots\n");
  EXPECT_FALSE(context_->panels["plots"]);
  EXPECT_NE(refusalOf("view.plots loud\n").find("on or off"), std::string::npos);
}

// Faster than the reports, and beyond the capacity of the 1 kHz thread's queue.
TEST_F(TimelineTest, GoesOverMoreStepsThanTheQueueTakes) {
  stroke(180);
  const double removed = bench_->document->removedMm3();
  const std::uint32_t id = bench_->document->scene().shown().front()->id;
  constexpr int kMoves = 100;
  for (int n = 1; n <= kMoves; ++n) {
    bench_->pieces->move(id, {Eigen::Quaterniond::Identity(), {0, 0, 0.01 * n}});
    bench_->update();
    std::this_thread::sleep_for(std::chrono::milliseconds(4));
  }
  run("wait 0.1\nexpect steps 101 101\n");
  EXPECT_EQ(bench_->steps->timeline().steps().back().kind, TimelineStep::Kind::kMove);
  // Dragged to and fro, without waiting.
  run("edit.go 40\nedit.go 90\nedit.go 3\nedit.undo\nedit.undo\nedit.redo\nwait 1\nexpect steps 2 2\n");
  EXPECT_NEAR(bench_->document->report().objects[0].T_world_object.translation[2], 0.01, 1e-12);
  EXPECT_NEAR(bench_->document->removedMm3(), removed, 1e-9);
  run("edit.go 0\nwait 0.5\nexpect removed -1e-9 1e-9\nedit.end\nwait 1\nexpect steps 101 101\n");
  EXPECT_NEAR(bench_->document->report().objects[0].T_world_object.translation[2], 1, 1e-12);
  const auto replayed = replayRun(end());
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
}

TEST_F(TimelineTest, APlannedCutIsGoneOverInOneStep) {
  stroke(150);
  const double before = bench_->document->removedMm3();
  run("tool.select saw-reciprocating-25\nsaw.plane 1.5 0 -1 1 0 0\nsaw.cut\nwait 4\nsaw.stop\nwait\nwait 0.2\n"
      "expect steps 2 2\n");
  const double after = bench_->document->removedMm3();
  ASSERT_GT(after, before + 0.1);
  EXPECT_EQ(bench_->steps->timeline().steps()[1].kind, TimelineStep::Kind::kPlannedCut);
  goTo(1);
  EXPECT_NEAR(bench_->document->removedMm3(), before, 1e-9);
  run("edit.redo\nwait 0.3\nexpect steps 2 2\n");
  EXPECT_NEAR(bench_->document->removedMm3(), after, 1e-9);
  run("edit.undo\nedit.undo\nwait 0.3\nexpect steps 0 0\nexpect removed -1e-9 1e-9\n");
}

}  // namespace
}  // namespace kerf::timeline_test
