// Holes at typed places: depth, width and place in the file, undo, replay.
#include "ui/app/workbench/drilling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/mesh/mesh_check.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/report/replay.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "tests/ui/block_on_bench.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"

namespace kerf::drilling_test {
namespace {

namespace fs = std::filesystem;

// A block of 16 x 12 x 12 mm, its top at z = 0, its left front corner at -8, -6.
class DrillingTest : public testing::Test {
 protected:
  static constexpr double kVoxel = 0.15;

  void SetUp() override {
    const fs::path scan = folder_.path() / "block.ply";
    ASSERT_TRUE(writeMesh(scan, test::blockMesh(true, {16, 12, 12})));
    WorkbenchOptions options;
    options.data_folder = folder_.path() / "data";
    options.tools = {"twist-20", "round-014", "saw-sagittal-6", "847-016"};
    options.voxel_mm = kVoxel;
    options.real_time = {.priority = 0, .lock_memory = false};
    bench_ = std::make_unique<Workbench>(options);
    bench_->sessions->open(scan);
    work();
    ASSERT_TRUE(bench_->document->isOpen()) << allNotices();
    camera_.half_height = 10;
    camera_.target = {0, 0, -6};
  }
  void TearDown() override { end(); }

  void work() {
    do bench_->update();
    while (bench_->jobs->running() || (bench_->document->isOpen() && bench_->document->scene().triangleCount() == 0));
  }
  fs::path end() {
    const fs::path session = bench_->document->sessionFolder();
    bench_->sessions->close();
    work();
    return session;
  }
  Expected<void> play(const std::string& script) {
    AppContext context{.bench = *bench_, .camera = camera_, .width = 400, .height = 300};
    return runScript(context, folder_.write("script.ks", script), [&] { bench_->update(); });
  }
  std::string allNotices() const {
    std::string out;
    for (const Notice& notice : bench_->notices->list()) out += notice.text + "\n";
    return out;
  }

  TemporaryFolder folder_;
  std::unique_ptr<Workbench> bench_;
  Camera camera_ = *cameraFromView("top");
};

// Of the wall of a hole along z, between two heights.
struct Wall {
  double narrowest = 1e9, widest = 0, lowest = 0;
  std::size_t count = 0;
};
Wall wallOf(const Mesh& mesh, double x, double y, double from, double to) {
  Wall out;
  for (const Vec3d& v : mesh.vertices) {
    const double r = std::hypot(v[0] - x, v[1] - y);
    if (r > 1.6) continue;
    if (v[2] > -11.9) out.lowest = std::min(out.lowest, v[2]);
    if (v[2] < to || v[2] > from) continue;
    out.narrowest = std::min(out.narrowest, r);
    out.widest = std::max(out.widest, r);
    ++out.count;
  }
  return out;
}

TEST_F(DrillingTest, TwoHolesAtTypedPlacesAreExactInTheFile) {
  const auto played =
      play("drill.depth 10\ndrill.at 5 6\ndrill.go\nwait\ndrill.at 11 6\ndrill.go\nwait\nexpect steps 2 2\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  EXPECT_NE(allNotices().find("Hole 2: depth reached 10.0 mm, 2.0 mm wide"), std::string::npos) << allNotices();
  const fs::path run = end();
  const auto exported = exportBundle(run);
  ASSERT_TRUE(exported) << exported.error().message();
  const Mesh& mesh = exported->post_op.mesh;
  const MeshReport report = checkMesh(mesh);
  EXPECT_TRUE(report.print_ready);
  EXPECT_EQ(report.pieces, 1u);
  for (const double x : {-3.0, 3.0}) {
    const Wall wall = wallOf(mesh, x, 0, -0.5, -9);
    ASSERT_GT(wall.count, 100u);
    EXPECT_NEAR(wall.narrowest, 1, 0.5 * kVoxel);
    EXPECT_NEAR(wall.widest, 1, 0.5 * kVoxel);
    EXPECT_NEAR(wall.lowest, -10, 0.5 * kVoxel);
  }
  const auto replayed = replayRun(run);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
}

TEST_F(DrillingTest, ThroughComesOutWithTheFullWidthAndUndoTakesOneHoleBack) {
  const auto played =
      play("drill.depth through\ndrill.at 8 6\ndrill.go\nwait\nwait 0.3\nexpect steps 1 1\nexpect removed 36 40\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  EXPECT_NE(allNotices().find("Hole 1: through"), std::string::npos) << allNotices();
  ASSERT_TRUE(play("edit.undo\nwait 0.3\nexpect removed -1e-9 1e-9\nexpect steps 0 0\nedit.redo\nwait 0.3\n"));
  const auto exported = exportBundle(end());
  ASSERT_TRUE(exported) << exported.error().message();
  const MeshReport report = checkMesh(exported->post_op.mesh);
  EXPECT_TRUE(report.print_ready);
  const Wall wall = wallOf(exported->post_op.mesh, 0, 0, -0.5, -11.5);
  EXPECT_NEAR(wall.narrowest, 1, 0.5 * kVoxel);
}

TEST_F(DrillingTest, TheWallsThatStayAreTold) {
  ASSERT_TRUE(play("drill.depth 10\ndrill.at 3 6\n"));
  const auto readout = bench_->drill->readout(camera_);
  ASSERT_TRUE(readout);
  EXPECT_NEAR((readout->place - Vec3d(3, 6, 12)).norm(), 0, 0.02);
  EXPECT_NEAR(bench_->drill->hole()->entry[0], -5, 1e-9);
  ASSERT_TRUE(readout->walls.edge && readout->walls.beside && readout->walls.beneath);
  EXPECT_NEAR(*readout->walls.edge, 3, 0.02);
  EXPECT_NEAR(*readout->walls.beside, 2, 0.02);
  EXPECT_NEAR(*readout->walls.beneath, 2, 0.02);
  EXPECT_NEAR(readout->full_to, 10 - 1 / std::tan(59 * M_PI / 180), 0.01);

  ASSERT_TRUE(play("drill.at 0.5 6\n"));
  EXPECT_LT(*bench_->drill->readout(camera_)->walls.beside, 0) << "it breaks out";
  ASSERT_TRUE(play("drill.at 3 6\ndrill.depth through\n"));
  EXPECT_LT(*bench_->drill->readout(camera_)->walls.beneath, 0);
}

TEST_F(DrillingTest, TheAxisIsThatOfTheModelOfTheSurfaceOrOfTheView) {
  ASSERT_TRUE(play("view.front\ndrill.click 200 150\n") || !bench_->drill->hole());
  EXPECT_FALSE(bench_->drill->hole()) << "the vertical axis runs along the front";
  ASSERT_TRUE(play("drill.axis face\ndrill.click 200 150\n"));
  EXPECT_NEAR((bench_->drill->hole()->axis + Vec3d::UnitY()).norm(), 0, 0.01);
  ASSERT_TRUE(play("view.iso\ndrill.axis view\ndrill.click 200 150\n"));
  EXPECT_NEAR((bench_->drill->hole()->axis - camera_.backwards()).norm(), 0, 1e-9);
  ASSERT_TRUE(play("view.bottom\ndrill.at 8 6\ndrill.axis vertical\n"));
  EXPECT_NEAR((bench_->drill->hole()->axis + Vec3d::UnitZ()).norm(), 0, 1e-9) << "from the viewer's side";
  EXPECT_NEAR(bench_->drill->hole()->entry[2], -12, 0.01);
}

TEST_F(DrillingTest, WhatCannotBeDrilledIsSaidWithWhatToDo) {
  const std::pair<std::string, const char*> cases[] = {
      {"drill.go", "not available now"},
      {"drill.at 40 6", "0 to 16.0 and 0 to 12.0 mm"},
      {"drill.at 8", "Y"},
      {"drill.depth deep", "MM"},
      {"drill.axis sideways", "vertical, occlusal, face or view"},
      {"drill.plan on\ndrill.go", "no place for a hole"},
      {"tool.select saw-sagittal-6\ndrill.plan on", "does not cut with its end"},
      {"tool.select round-014\ndrill.depth 10\ndrill.at 8 6\ndrill.go", "wider part"}};
  for (const auto& [script, words] : cases) {
    const auto played = play(script);
    ASSERT_FALSE(played) << script;
    EXPECT_NE(played.error().message().find(words), std::string::npos) << script << ": " << played.error().message();
  }
  EXPECT_EQ(bench_->document->removedMm3(), 0);
}

TEST_F(DrillingTest, StoppedOrUndoneTheDrillComesOutFirst) {
  ASSERT_TRUE(play("drill.depth 10\ndrill.at 8 6\ndrill.go\nwait 2\n"));
  EXPECT_TRUE(bench_->saw->isCutting());
  EXPECT_FALSE(play("drill.go\n")) << "one at a time";
  EXPECT_FALSE(bench_->strokes->press(rayUnder(camera_, 300, 150, 400, 300))) << "the tool is in use";
  const auto stopped = play("drill.stop\nwait\nwait 0.3\nexpect steps 1 1\nexpect removed 1 25\n");
  ASSERT_TRUE(stopped) << stopped.error().message() << allNotices();
  EXPECT_NE(allNotices().find("stopped at"), std::string::npos) << allNotices();
  const auto undone =
      play("edit.undo\nwait 0.3\ndrill.go\nwait 2\nedit.undo\nwait\nwait 0.5\nexpect removed -1e-9 1e-9\n");
  ASSERT_TRUE(undone) << undone.error().message() << allNotices();
}

// ---- A held axis

TEST_F(DrillingTest, AHeldAxisStaysOnTopAndOnTheWalls) {
  const auto offAxis = [&] {
    const Vec3d axis = bench_->document->report().output.T_world_tool.rotation * Vec3d::UnitZ();
    return std::acos(std::min(axis.dot(*bench_->strokes->heldAxis()), 1.0)) * 180 / M_PI;
  };
  ASSERT_TRUE(play("tool.select 847-016\nview.top\ntool.hold-axis view\ncut.depth 0.4\ncut.force 2\n"));
  double worst = 0;
  const auto held = [&](const std::string& script) {
    ASSERT_TRUE(play(script)) << script << allNotices();
    worst = std::max(worst, offAxis());
  };
  held("view.front\ncut.press 200 120\nwait 1\n");
  for (int x = 205; x <= 260; x += 5) held(fmt::format("cut.drag {} 120\nwait 0.2\n", x));
  held("cut.release\nwait 0.2\nexpect removed 0.2 20\n");
  const double on_wall = bench_->document->removedMm3();
  held("view.top\ncut.press 200 150\nwait 1.5\ncut.drag 240 150\nwait 1\n");
  held("cut.release\nwait 0.2\n");
  EXPECT_GT(bench_->document->removedMm3(), on_wall + 0.1);
  EXPECT_LT(worst, 0.3) << "degrees";
  EXPECT_FALSE(play("view.bottom\ncut.press 200 150\n"));
  EXPECT_NE(allNotices().find("undercut"), std::string::npos) << allNotices();
  const auto replayed = replayRun(end());
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same) << replayed->note;
}

}  // namespace
}  // namespace kerf::drilling_test
