#include "ui/app/workbench/sawing.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/report/replay.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/saw/saw_contour.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"
#include "ui/app/workbench/workbench.h"

namespace kerf::sawing_test {
namespace {

namespace fs = std::filesystem;

// A bar like the body of a mandible, 16 mm long, 5 mm wide and 4 mm high, its top at z = 0.
Mesh bar() {
  Mesh out;
  for (int n = 0; n < 8; ++n) out.vertices.push_back({n & 1 ? 8.0 : -8.0, n & 2 ? 2.5 : -2.5, n & 4 ? 0.0 : -4.0});
  out.triangles = {{4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                   {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}, {0, 2, 1}, {1, 2, 3}};
  return out;
}

// 400 x 300 pixels from above: 0.05 mm a pixel, the middle of the bar's top at (200, 150).
class SawingTest : public testing::Test {
 protected:
  void SetUp() override {
    scan_ = folder_.path() / "bar.ply";
    ASSERT_TRUE(writeMesh(scan_, bar()));
    WorkbenchOptions options;
    options.data_folder = folder_.path() / "data";
    options.tools = {"saw-sagittal-6", "saw-reciprocating-25", "round-014", "saw-piezo-050"};
    options.voxel_mm = 0.1;
    options.real_time = {.priority = 0, .lock_memory = false};
    bench_ = std::make_unique<Workbench>(options);
    bench_->sessions->open(scan_);
    work();
    ASSERT_TRUE(bench_->document->isOpen()) << allNotices();
    camera_.half_height = 7.5;
    camera_.target = {0, 0, -2};
  }
  void TearDown() override { end(); }

  void end() {
    if (!bench_) return;
    session_ = bench_->document->sessionFolder();
    bench_->sessions->close();
    work();
  }
  void work() {
    do bench_->update();
    while (bench_->jobs->running() || (bench_->document->isOpen() && bench_->document->scene().triangleCount() == 0));
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
  void lookFromInFront() {
    camera_ = *cameraFromView("0,45");
    camera_.half_height = 7.5;
    camera_.target = {0, 0, -2};
  }
  std::string pixelOf(const Vec3d& p) const {
    const Vec3d v = camera_.rotation() * (p - camera_.target) / camera_.mmPerPixel(300);
    return fmt::format(" {:.6f} {:.6f}", 200 + v[0], 150 - v[1]);
  }
  Ray rayTo(const Vec3d& p) const {
    const Vec3d v = camera_.rotation() * (p - camera_.target) / camera_.mmPerPixel(300);
    return rayUnder(camera_, 200 + v[0], 150 - v[1], 400, 300);
  }
  const SawPlane& plane() const { return *bench_->saw->plan().chosen(); }

  TemporaryFolder folder_;
  fs::path scan_, session_;
  std::unique_ptr<Workbench> bench_;
  Camera camera_ = *cameraFromView("top");
};

// ---- Planning

TEST_F(SawingTest, PlanesDrawnInPerspectiveContainTheEyeAndWhatWasUnderTheCursor) {
  const double edge_on = 1e-6;
  ASSERT_TRUE(play("view.perspective 60\nsaw.line 250 80 260 230\n"));
  const auto eye = [&]() -> Vec3d { return camera_.target + camera_.eyeDistance() * camera_.backwards(); };
  EXPECT_NEAR(plane().toPlane(eye())[2], 0, edge_on);
  EXPECT_GT(std::abs(plane().normal[2]), 0.05) << "it leans to the eye";
  for (const auto& [x, y] : {std::array{250.0, 80.0}, {260.0, 230.0}}) {
    const Ray ray = rayUnder(camera_, x, y, 400, 300);
    EXPECT_NEAR(plane().toPlane(ray.at(10))[2], 0, edge_on);
  }
  ASSERT_TRUE(play("saw.plane-from-view 280 150\n"));
  EXPECT_NEAR(plane().toPlane(eye())[2], 0, edge_on);
}

TEST_F(SawingTest, EveryWayOfPlanningMakesAPlaneOfTheBar) {
  // A line from below to above in the picture, seen from the top: x = 1.
  ASSERT_TRUE(play("saw.line 220 60 220 240\n"));
  EXPECT_NEAR(std::abs(plane().normal[0]), 1, 1e-9);
  EXPECT_NEAR(plane().point[0], 1, 1e-9);
  EXPECT_NEAR(plane().approach[2], -1, 1e-9);
  EXPECT_NEAR(plane().width, 6, 0.3) << "5 mm of bone and its margins";
  EXPECT_NEAR(plane().depth, 5.5, 0.3);
  EXPECT_NEAR(plane().point[2], 0.5, 0.3);

  ASSERT_TRUE(play("saw.line 220 140 220 160\n"));
  EXPECT_NEAR(plane().width, 1, 1e-9) << "no wider than the line";

  ASSERT_TRUE(play("saw.plane-from-view 180 150\n"));
  EXPECT_NEAR(plane().point[0], -1, 1e-9);

  ASSERT_TRUE(play("saw.plane-from-face 200 150 1.5\n"));
  EXPECT_NEAR(std::abs(plane().normal[2]), 1, 1e-3);
  EXPECT_NEAR(plane().toPlane({0, 0, -1.5})[2], 0, 0.02);

  // Three points: one on the front, two on the top.
  lookFromInFront();
  ASSERT_TRUE(play("saw.plane-from-points" + pixelOf({2, -2.5, -3}) + pixelOf({2, 2, 0}) + pixelOf({2, -1, 0}) + "\n"));
  EXPECT_NEAR(std::abs(plane().normal[0]), 1, 1e-6);
  EXPECT_NEAR(plane().point[0], 2, 0.01);
  EXPECT_LT(plane().approach[2], -0.5) << "down";

  ASSERT_TRUE(play("saw.plane 3 0 -2 1 0 0\n"));
  EXPECT_NEAR(plane().point[0], 3, 1e-9);
  EXPECT_EQ(bench_->saw->plan().planes().size(), 6u);
}

TEST_F(SawingTest, TheContourOfAPlaneIsWhereItMeetsTheBarWithinItsRectangle) {
  ASSERT_TRUE(play("saw.line 220 60 220 240\n"));
  SawPlane cut = plane();
  const auto lengthOf = [&] {
    double length = 0;
    for (const auto& piece : contourOf(cut, bench_->document->scene())) {
      length += (piece[1] - piece[0]).norm();
      for (const Vec3d& p : piece) {
        const Vec3d at = cut.toPlane(p);
        EXPECT_NEAR(at[2], 0, 1e-3);
        EXPECT_LE(std::abs(at[0]), 0.5 * cut.width);
        EXPECT_TRUE(at[1] >= 0 && at[1] <= cut.depth) << at[1];
      }
    }
    return length;
  };
  EXPECT_NEAR(lengthOf(), 2 * (5 + 4), 0.8) << "all around";
  cut.depth = cut.point[2] + 2;
  EXPECT_NEAR(lengthOf(), 5 + 2 * 2, 0.8) << "down to the middle of the bar";
}

TEST_F(SawingTest, StepsNamesAndFiles) {
  const std::string file = (folder_.path() / "plan.toml").string();
  ASSERT_TRUE(play("saw.plane 3 0 -2 1 0 0\nsaw.move 0.1\nsaw.turn 10\nsaw.depth 2\nsaw.rename distal\n"));
  EXPECT_NEAR(plane().point[0], 3.1, 1e-9);
  EXPECT_NEAR(plane().normal[0], std::cos(10 * M_PI / 180), 1e-9);
  EXPECT_NEAR(plane().depth, 2, 1e-9);
  const Vec3d normal = plane().normal;
  ASSERT_TRUE(play("saw.plane -3 0 -2 1 0 0\nsaw.save \"" + file +
                   "\"\nsaw.choose distal\nsaw.delete\nsaw.delete\nsaw.load \"" + file + "\"\nsaw.choose distal\n"));
  EXPECT_EQ(bench_->saw->plan().planes().size(), 2u);
  EXPECT_EQ(plane().normal, normal);
  ASSERT_TRUE(play("saw.fit\n"));
  EXPECT_NEAR(plane().depth, 5.5, 0.4);

  const std::string slicer = folder_
                                 .write("cut.mrk.json", R"({"markups": [{"type": "Plane", "coordinateSystem": "RAS",
    "center": [-2, 0, -2], "normal": [-1, 0, 0]}]})")
                                 .string();
  ASSERT_TRUE(play("saw.load \"" + slicer + "\"\n"));
  EXPECT_EQ(bench_->saw->plan().planes().size(), 1u);
  EXPECT_EQ(plane().normal, Vec3d::UnitX()) << "in the frame of the scan";
  EXPECT_EQ(plane().name, "cut");
  EXPECT_NE(bench_->notices->list().back().text.find("x and y negated (RAS)"), std::string::npos);
}

TEST_F(SawingTest, ByMouseThreeClicksOrALineMakeAPlane) {
  Sawing& saw = *bench_->saw;
  const auto at = [&](double x, double y) { return rayUnder(camera_, x, y, 400, 300); };
  saw.picking.begin(SawPicking::What::kLine);
  EXPECT_NE(saw.picking.hint().find("Esc"), std::string::npos);
  ASSERT_TRUE(saw.picking.press(saw, at(220, 60)));
  saw.picking.move(at(220, 100));
  EXPECT_TRUE(saw.picking.lineFrom());
  ASSERT_TRUE(saw.picking.release(saw, at(220, 240)));
  EXPECT_EQ(saw.picking.what(), SawPicking::What::kNothing);
  EXPECT_NEAR(plane().point[0], 1, 1e-9);

  lookFromInFront();
  saw.picking.begin(SawPicking::What::kPoints);
  ASSERT_TRUE(saw.picking.press(saw, rayTo({2, -2.5, -3})));
  EXPECT_FALSE(saw.picking.press(saw, at(2, 2))) << "beside the bar: asked again";
  ASSERT_TRUE(saw.picking.press(saw, rayTo({2, 2, 0})));
  EXPECT_EQ(saw.picking.points().size(), 2u);
  ASSERT_TRUE(saw.picking.press(saw, rayTo({2, -1, 0})));
  EXPECT_EQ(saw.plan().planes().size(), 2u);
  EXPECT_TRUE(saw.picking.hint().empty());

  saw.picking.begin(SawPicking::What::kPoints);
  ASSERT_TRUE(play("saw.pick-nothing\n"));
  EXPECT_EQ(saw.picking.what(), SawPicking::What::kNothing);
}

TEST_F(SawingTest, WhatCannotBePlannedOrSawnIsSaidWithWhatToDo) {
  const std::pair<std::string, const char*> cases[] = {
      {"saw.cut", "not available now"},
      {"saw.move 1", "not available now"},
      {"saw.line 2 2 2 40", "misses the object"},
      {"saw.line 200 150 200 151", "right across"},
      {"saw.line 200 150", "too few"},
      {"saw.plane-from-points 2 2 200 150 220 150", "nothing is there"},
      {"saw.plane-from-points 180 150 200 150 220 150", "off the line"},
      {"saw.plane 0 0 0 0 0 0", "not all zero"},
      {"saw.plane 80 0 0 1 0 0", "no bone"},
      {"saw.load /nowhere/plan.toml", "/nowhere/plan.toml"},
      {"saw.guide maybe", "on or off"},
      {"saw.plane 0 0 -2 1 0 0\nsaw.choose mesial", "plane 1"},
      {"tool.select round-014\nsaw.cut", "saw-sagittal-6, saw-reciprocating-25, saw-piezo-050"},
      {"tool.select saw-sagittal-6\nsaw.cut 99", "0.5 to 8"},
      {"saw.move 40\nsaw.cut", "no bone in the plane"}};
  for (const auto& [script, words] : cases) {
    const auto played = play(script);
    ASSERT_FALSE(played) << script;
    EXPECT_NE(played.error().message().find(words), std::string::npos) << script << ": " << played.error().message();
  }
  EXPECT_EQ(bench_->document->removedMm3(), 0);
}

// ---- Sawing

TEST_F(SawingTest, ABarIsSawnThroughInThePlaneAndReplaysBitForBit) {
  const fs::path out = folder_.path() / "sawn.stl";
  const auto played =
      play("saw.plane 0.3 0 -2 1 0.2 0.1\nsaw.rename distal\nsaw.cut 6\nwait\nexpect sawn 99.5 100\nfile.export \"" +
           out.string() + "\"\nwait\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  EXPECT_NE(allNotices().find("distal: cut 100 %"), std::string::npos) << allNotices();
  EXPECT_NE(allNotices().find("ready to print"), std::string::npos) << allNotices();
  // Planned against actual volume: the section of the bar times the kerf.
  const std::size_t told = allNotices().find(" mm3 planned, ");
  ASSERT_NE(told, std::string::npos) << allNotices();
  const double removed = std::stod(allNotices().substr(told + std::strlen(" mm3 planned, ")));
  const double planned = std::stod(allNotices().substr(allNotices().rfind(' ', told - 1)));
  EXPECT_NEAR(removed / planned, 1, 0.05) << allNotices();

  const auto mesh = readMesh(out);
  ASSERT_TRUE(mesh);
  const MeshReport report = checkMesh(mesh->mesh);
  EXPECT_EQ(report.pieces, 2u) << "sawn right through";

  // The walls of the kerf lie in the plane, as far apart as the blade's teeth.
  const double kerf = bench_->tools->at(bench_->tools->inHand()).kerfWidth();
  double worst = 0, area = 0;
  for (const Triangle& t : mesh->mesh.triangles) {
    const Vec3d& a = mesh->mesh.vertices[t[0]];
    const Vec3d square = (mesh->mesh.vertices[t[1]] - a).cross(mesh->mesh.vertices[t[2]] - a);
    if (std::abs(square.dot(plane().normal)) < 0.97 * square.norm() || square.norm() < 1e-9) continue;
    const Vec3d middle = (a + mesh->mesh.vertices[t[1]] + mesh->mesh.vertices[t[2]]) / 3;
    const double height = plane().toPlane(middle)[2];
    if (std::abs(height) > 2) continue;  // the ends of the bar
    area += 0.5 * square.norm();
    worst = std::max(worst, std::abs(std::abs(height) - 0.5 * kerf));
  }
  EXPECT_NEAR(area, 2 * 5 * 4 / plane().normal.head<1>().norm(), 4) << "two walls of the section";
  EXPECT_LE(worst, 0.05) << "mm off the plane";

  end();
  const auto replayed = replayRun(session_);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_TRUE(fs::exists(session_ / kSawPlanFile));
  SawPlan plan;
  ASSERT_TRUE(plan.load(session_ / kSawPlanFile));
  EXPECT_EQ(plan.chosen()->name, "distal");
}

TEST_F(SawingTest, StoppedItLeavesAUsableSessionAndOneStroke) {
  const auto played = play("tool.select saw-reciprocating-25\nsaw.plane 0 0 -2 1 0 0\nsaw.cut\nwait 2.5\n");
  ASSERT_TRUE(played) << played.error().message();
  ASSERT_TRUE(bench_->saw->isCutting());
  EXPECT_FALSE(play("saw.cut\n")) << "one at a time";
  EXPECT_FALSE(bench_->strokes->press(rayUnder(camera_, 300, 150, 400, 300))) << "the tool is in use";
  const auto status = bench_->saw->status();
  ASSERT_TRUE(status);
  EXPECT_GT(status->share, 0.02);
  EXPECT_LT(status->share, 0.9);

  const auto stopped = play(
      "saw.stop\nwait\nexpect sawn 2 90\nexpect removed 0.1 9\nedit.undo\nwait 0.3\nexpect removed -1e-9 1e-9\n"
      "tool.select round-014\ncut.press 300 150\nwait 1.5\ncut.release\nwait 0.2\nexpect removed 0.001 "
      "9\nedit.undo\nwait 0.3\n"
      "expect removed -1e-9 1e-9\n");
  ASSERT_TRUE(stopped) << stopped.error().message() << allNotices();
  EXPECT_NE(allNotices().find("stopped after"), std::string::npos) << allNotices();
}

TEST_F(SawingTest, UndoneWhileItSawsTheBladeComesOutFirst) {
  const auto played = play("tool.select saw-reciprocating-25\nsaw.plane 0 0 -2 1 0 0\nsaw.cut\nwait 2.5\nedit.undo\n");
  ASSERT_TRUE(played) << played.error().message();
  EXPECT_TRUE(bench_->saw->isCutting());
  EXPECT_FALSE(play("tool.select round-014\n")) << "a bur in the place of the blade would stand in the bone";
  EXPECT_EQ(bench_->tools->at(bench_->tools->inHand()).id, "saw-reciprocating-25");
  for (int n = 0; n < 400 && bench_->saw->isCutting(); ++n) {
    bench_->update();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const std::size_t before = bench_->document->report().tick;
  while (bench_->document->report().tick < before + 300) bench_->update();
  EXPECT_NEAR(bench_->document->removedMm3(), 0, 1e-9);
  EXPECT_FALSE(bench_->saw->isCutting());
}

TEST_F(SawingTest, WhatTheBladeDoesNotReachIsSaid) {
  // Planned lengthwise for a saw that sweeps. The piezo tip is held at its end, and spans 8.1 of 16 mm.
  const auto played =
      play("saw.line 30 150 370 150\nsaw.depth 1.5\ntool.select saw-piezo-050\nsaw.cut 8\nwait\nexpect sawn 40 55\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  EXPECT_NE(allNotices().find("beyond the blade's reach"), std::string::npos) << allNotices();
}

TEST_F(SawingTest, AShortBladeSweeps) {
  const auto played = play("saw.line 30 150 370 150\nsaw.depth 1.2\nsaw.cut 8\nwait\nexpect sawn 80 100\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  // A slot 16 x 0.7 mm: teeth on an arc leave part of its floor, and wander a little before the kerf guides them.
  const double slot = 16 * 0.7 * bench_->tools->at(0).kerfWidth();
  EXPECT_GE(bench_->document->removedMm3(), 0.85 * slot);
  EXPECT_LE(bench_->document->removedMm3(), 1.4 * slot);
}

TEST_F(SawingTest, AlongTheGuideTheMouseMovesTheBladeInThePlaneAlone) {
  const auto played = play(
      "saw.plane 0.5 0 -2 1 0 0\nsaw.guide on\ncut.force 4\ncut.depth 1\ncut.press 205 150\nwait 3\n"
      "cut.drag 260 130\nwait 2\ncut.drag 150 170\nwait 2\nexpect depth 0.9 1.05\ncut.release\nwait 0.5\n"
      "expect removed 0.3 5\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  const double half = 0.5 * bench_->tools->at(bench_->tools->inHand()).kerfWidth(), voxel = 0.1;
  double widest = 0;
  for (double x = -2; x < 3; x += 0.01)
    for (double y = -2; y <= 2; y += 0.25) {
      const auto top = bench_->document->scene().hit({{x, y, 5}, -Vec3d::UnitZ()});
      if (top && top->on_surface.point[2] < -0.3) widest = std::max(widest, std::abs(x - 0.5));
    }
  EXPECT_NEAR(widest, half, 0.5 * voxel) << "mm beside the plane";
  EXPECT_FALSE(bench_->strokes->over(rayUnder(camera_, 390, 150, 400, 300)))
      << "far beside the plane there is nothing to saw";
}

}  // namespace
}  // namespace kerf::sawing_test
