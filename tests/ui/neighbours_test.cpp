// A workbench with a work block and another block beside it, 0.3 mm away.
#include "ui/app/session/neighbours.h"

#include <algorithm>
#include <cstdlib>

#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/bake/pair.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/report/replay.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/places.h"
#include "tests/ui/block_on_bench.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/view_state.h"
#include "ui/app/readout/point_readout.h"
#include "ui/app/script/app_script.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/app/workbench/tools.h"

namespace kerf::neighbours_test {
namespace {

namespace fs = std::filesystem;

Ray from(double x, double y) { return {{x, y, 20}, {0, 0, -1}}; }

class NeighboursTest : public test::StrokePointerTest {
 protected:
  // Its top at z = 0, 6 x 4 x 3 mm, without underside.
  fs::path block(const std::string& name, const Vec3d& shift, const Vec3d& size = {6, 4, 3}, double scale = 1) {
    Mesh mesh = test::blockMesh(false, size);
    for (Vec3d& v : mesh.vertices) v = scale * (v + shift);
    const fs::path file = folder_.path() / (name + ".ply");
    EXPECT_TRUE(writeMesh(file, mesh));
    return file;
  }
  void SetUp() override {
    bench_.strokes->depth_mm = 0.5;
    bench_.strokes->setForce(2);
  }
  void TearDown() override {
    settle();
    bench_.sessions->close();
    settle();
  }
  void until(const std::function<bool()>& is_so) {
    do {
      bench_.update();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    } while (!is_so());
  }
  void settle() {
    until([&] {
      return !bench_.jobs->running() && (!bench_.document->isOpen() || bench_.document->scene().triangleCount() > 0);
    });
  }
  void run(double seconds) {
    const auto end = bench_.document->report().tick + static_cast<std::uint64_t>(seconds / kTick);
    until([&] { return bench_.document->report().tick >= end; });
  }
  void openBoth() {
    bench_.sessions->openAll({block("36", {0, 0, 0}), block("35", {6.3, 0, 0})});
    settle();
    ASSERT_TRUE(bench_.document->isOpen()) << said();
    ASSERT_EQ(bench_.neighbours->list().size(), 1u);
  }
  void drill(double x, double y, double seconds) {
    ASSERT_TRUE(bench_.strokes->press(from(x, y)));
    run(seconds);
    bench_.strokes->release();
    run(0.3);
  }
  std::string said() const {
    std::string out;
    for (const Notice& notice : bench_.notices->list()) out += notice.text + "\n";
    return out;
  }
  bool hasSaid(const std::string& text) const { return said().find(text) != std::string::npos; }
  // A bur of 1.4 mm there, 0.4 mm from the gap, reaches into the neighbour.
  static constexpr double kBetween = 2.9;
};

TEST_F(NeighboursTest, ItIsSeenAndPointedAtButNotWorkedOn) {
  openBoth();
  EXPECT_EQ(bench_.document->name(), "36");
  EXPECT_EQ(bench_.neighbours->list()[0].name, "35");
  until([&] { return bench_.document->scene().shown().size() == 2; });
  EXPECT_EQ(bench_.document->scene().pieceCount(), 1u);
  EXPECT_NEAR(bench_.document->scene().bounds().max[0], 9.3, 0.1);

  const auto point = readoutAt(bench_, from(6, 0));
  ASSERT_TRUE(point);
  EXPECT_EQ(point->piece, "neighbour 35");
  EXPECT_NEAR(point->point[2], 0, 0.05);
  EXPECT_FALSE(bench_.strokes->over(from(6, 0)));
  EXPECT_FALSE(bench_.strokes->press(from(6, 0)));
  EXPECT_TRUE(hasSaid("35 is a neighbour and cannot be cut")) << said();
  EXPECT_TRUE(readoutAt(bench_, from(0, 0))->piece.empty());

  // The pointer ignores a ghost. It cannot be moved or renamed either.
  const SceneObject* const other = bench_.neighbours->find("35");
  ASSERT_TRUE(other);
  bench_.neighbours->makeGhost(other->id, true);
  EXPECT_FALSE(readoutAt(bench_, from(6, 0)));
  bench_.pieces->move(other->id, {Eigen::Quaterniond::Identity(), {5, 0, 0}});
  run(0.1);
  EXPECT_EQ(bench_.neighbours->find("35")->pose().translation, Vec3d::Zero());
  EXPECT_TRUE(hasSaid("cannot be moved")) << said();
  // A script that requests it ends there.
  const std::vector<std::string> words{"5", "0", "0", other->name};
  const auto moved = runAppCommand(context_, "piece.move", words);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, Error::Code::kUnsupported);
  EXPECT_EQ(moved.error().hint, "neighbour.work-on 1, then move that");

  // A cut at once by a plane through both leaves it whole, and says so.
  const auto run_command = [&](const char* id, std::vector<std::string> by) { return runAppCommand(context_, id, by); };
  ASSERT_TRUE(run_command("saw.plane", {"0", "0.3", "-1", "0", "1", "0"}));
  EXPECT_EQ(bench_.saw->neighboursInPlane(), "35");
  ASSERT_TRUE(run_command("piece.choose", {"2"}));
  const auto cut = run_command("plane.cut", {"both"}), deleted = run_command("piece.delete", {});
  ASSERT_FALSE(cut || deleted);
  EXPECT_NE(cut.error().hint.find("neighbour.work-on 1"), std::string::npos) << cut.error().hint;
  EXPECT_NE(deleted.error().found.find("a neighbour"), std::string::npos) << deleted.error().found;
  bench_.pieces->choose(std::nullopt);
  ASSERT_TRUE(run_command("plane.cut", {"both"}));
  until([&] { return bench_.document->scene().pieceCount() == 2; });
  EXPECT_EQ(bench_.document->scene().shown().size(), 3u);
  until([&] { return hasSaid("stays whole: 35"); });
  ASSERT_TRUE(run_command("edit.undo", {}));
  until([&] { return bench_.document->scene().pieceCount() == 1; });

  // Another colour than the work object's.
  const auto coloursOf = [&](const SceneObject& object) {
    Rgba8 out{};
    object.surface.forEachChunk([&](const MeshChunk& chunk) {
      if (!chunk.colours.empty()) out = chunk.colours.front();
    });
    return out;
  };
  EXPECT_NE(coloursOf(*bench_.document->scene().shown()[0]), coloursOf(*bench_.document->scene().shown()[1]));
}

// Voxels of 0.1 mm: distances to 0.3 mm are those of the baked field, others good to half a voxel.
constexpr double kInBand = 0.02, kHalfVoxel = 0.06;

TEST_F(NeighboursTest, ContactMapMeasuresTheGapOfTwoBlocks) {
  openBoth();
  TissueDisplay& tissues = bench_.views->tissues();
  for (const double y : {-1.0, 0.0, 1.0})
    for (const double away : {0.0, 0.1, 0.25, 1.0, 1.7}) {
      ASSERT_TRUE(tissues.toNeighbours({3 - away, y, -1.5}));
      EXPECT_NEAR(*tissues.toNeighbours({3 - away, y, -1.5}), 0.3 + away, away > 0 ? kHalfVoxel : kInBand) << away;
    }
  EXPECT_NEAR(*tissues.toNeighbours({3.5, 0, -1.5}), -0.2, kInBand);

  ASSERT_TRUE(runAppCommand(context_, "view.colours", std::vector<std::string>{"contact"}));
  ASSERT_EQ(tissues.colours(), SurfaceColours::kContact) << "live sessions have the distances";
  MeshChunk chunk;
  chunk.vertices = {{3, 0, -1.5f}, {-2.9f, 0, 0}};
  chunk.colours = {{200, 190, 180, 90}, {200, 190, 180, 90}};
  const auto near = tissues.coloursOf(chunk);
  EXPECT_GT(near[0][2], near[0][0]) << "blue";
  EXPECT_EQ(near[1], chunk.colours[1]) << "the usual colour";
  // Moved by 0.2 mm the piece is in contact, by 0.5 mm it overlaps.
  const auto moved = [&](double mm) {
    return tissues.coloursOf(chunk, {Eigen::Quaterniond::Identity(), {mm, 0, 0}})[0];
  };
  EXPECT_GT(moved(0.2)[1], 140) << "orange";
  EXPECT_LT(moved(0.5)[1], 40) << "red";
  EXPECT_GT(moved(0.5)[0], 120) << "red";
}

TEST_F(NeighboursTest, ContactMapMeasuresASphereOverAPlane) {
  const double radius = 2, gap = 0.1;
  const fs::path file = folder_.path() / "ball.ply";
  ASSERT_TRUE(writeMesh(file, ballMesh({0, 0, radius + gap}, radius, 120)));
  bench_.sessions->openAll({block("36", {0, 0, 0}), file});
  settle();
  ASSERT_EQ(bench_.neighbours->list().size(), 1u) << said();
  for (const double x : {0.0, 0.3, 0.6, 1.0, 1.5})
    for (const double z : {0.0, 0.2, -0.4}) {
      const double truth = std::hypot(x, radius + gap - z) - radius;
      EXPECT_NEAR(*bench_.views->tissues().toNeighbours({x, 0, z}), truth, truth > 0.3 ? kHalfVoxel : kInBand)
          << x << ' ' << z;
    }
}

TEST(ContactColours, AreBandsOfOverlapContactAndNearness) {
  const Rgba8 usual{220, 210, 190, 255};
  const MapScale smooth{2, false}, bands{2, true};
  EXPECT_EQ(contactColour(2, smooth, usual), usual);
  EXPECT_EQ(contactColour(3, smooth, usual), usual);
  EXPECT_EQ(contactColour(-0.5, smooth, usual), contactColour(-2, smooth, usual));
  EXPECT_GT(contactColour(-0.01, smooth, usual)[0], contactColour(-0.4, smooth, usual)[0] + 50) << "darker with depth";
  EXPECT_EQ(contactColour(0, smooth, usual), contactColour(kContactGap, smooth, usual));
  for (double mm = 0.25; mm < 1.9; mm += 0.1)
    EXPECT_LT(contactColour(mm, smooth, usual)[0], contactColour(mm + 0.1, smooth, usual)[0]) << "fades, at " << mm;
  EXPECT_EQ(contactColour(0.55, bands, usual), contactColour(0.95, bands, usual));
  EXPECT_NE(contactColour(0.95, bands, usual), contactColour(1.05, bands, usual));
  const auto legend = legendOf(SurfaceColours::kContact, smooth);
  ASSERT_TRUE(legend);
  EXPECT_EQ(legend->colourAt(0), contactColour(-0.5, smooth, {224, 214, 194, 255}));
  EXPECT_EQ(legend->colourAt(0.4), contactColour(0.1, smooth, {224, 214, 194, 255}));
  EXPECT_EQ(legendOf(SurfaceColours::kContact, {5, false})->high, "2 mm or more");
}

// The other jaw stands over the teeth; a tooth of the same arch does not.
TEST_F(NeighboursTest, ANeighbourOverTheTeethIsInOcclusion) {
  openBoth();
  EXPECT_FALSE(bench_.document->isNeighbourTowards({0, 0, 1}));
  EXPECT_TRUE(bench_.document->isNeighbourTowards({1, 0, 0}));
  EXPECT_FALSE(bench_.document->isNeighbourTowards({-1, 0, 0})) << "under it";
}

TEST_F(NeighboursTest, HowNearTheToolIsAndWhatWasCutByAccidentIsSaid) {
  openBoth();
  const auto over = bench_.strokes->over(from(kBetween, 0));
  ASSERT_TRUE(over);
  const auto hovering = bench_.monitor->nearNeighbour(over);
  ASSERT_TRUE(hovering);
  EXPECT_EQ(hovering->name, "35");
  // From a ball on the surface to the neighbour's edge: sqrt(0.4^2 + 0.7^2) - 0.7.
  EXPECT_NEAR(hovering->distance_mm, 0.106, 0.05);
  EXPECT_TRUE(bench_.monitor->nearNeighbour(bench_.strokes->over(from(-2, 0)))->is_far);

  ASSERT_TRUE(bench_.strokes->press(from(kBetween, 0)));
  until([&] { return bench_.neighbours->list()[0].removed_mm3 > 0.01; });
  EXPECT_LT(bench_.monitor->nearNeighbour({})->distance_mm, 0);
  EXPECT_FALSE(hasSaid("You cut the neighbour")) << "a stroke is not interrupted";
  bench_.strokes->release();
  run(0.4);
  const double removed = bench_.neighbours->list()[0].removed_mm3;
  EXPECT_TRUE(hasSaid(fmt::format("You cut the neighbour 35: {:.4f} mm3", removed))) << said();
  double of_object = 0;
  for (std::size_t n = 0; n < bench_.document->report().object_count; ++n)
    if (bench_.document->report().objects[n].loaded == 0) of_object += bench_.document->report().objects[n].removed_mm3;
  EXPECT_EQ(bench_.document->removedMm3(), of_object) << "what was cut off a neighbour does not count as work";

  bench_.steps->undo();
  until([&] { return bench_.neighbours->list()[0].removed_mm3 == 0; });
  EXPECT_EQ(bench_.document->removedMm3(), 0);
}

TEST_F(NeighboursTest, AStrokeStopsShortOfItWhenAsked) {
  openBoth();
  bench_.strokes->stopShortBeside(0.2);
  ASSERT_TRUE(bench_.strokes->press(from(2.6, 0)));
  double least = 1000;
  const auto end = bench_.document->report().tick + 4000;
  until([&] {
    if (const auto near = bench_.monitor->nearNeighbour({})) least = std::min(least, near->distance_mm);
    return bench_.document->report().tick >= end;
  });
  EXPECT_GT(least, 0.12);
  EXPECT_LT(least, 0.28);
  EXPECT_TRUE(bench_.monitor->nearNeighbour({})->is_stopped);
  bench_.strokes->release();
  run(0.2);
  EXPECT_EQ(bench_.neighbours->list()[0].removed_mm3, 0);

  // Without it the same stroke reaches its depth, and cuts the neighbour.
  bench_.strokes->stopShortBeside(std::nullopt);
  drill(2.6, 0, 4);
  EXPECT_LT(bench_.monitor->nearNeighbour(bench_.strokes->over(from(2.6, 0)))->distance_mm, 0.05);
}

TEST_F(NeighboursTest, BothAreExportedAndTheSessionReplays) {
  openBoth();
  drill(kBetween, 0, 3);
  const fs::path out = folder_.path() / "35-cut.stl";
  bench_.results->exportTo(out, {.beside = 1});
  settle();
  EXPECT_TRUE(hasSaid("ready to print")) << said();
  const auto mesh = readMesh(out);
  ASSERT_TRUE(mesh) << mesh.error().message();
  EXPECT_TRUE(checkMesh(mesh->mesh).print_ready);
  EXPECT_GT(bounds(mesh->mesh).min[0], 3.2);
  bench_.results->exportTo(folder_.path() / "35.ply", {.beside = 1});
  EXPECT_TRUE(hasSaid("never overwrites")) << said();

  const fs::path session = bench_.document->sessionFolder();
  bench_.sessions->close();
  settle();
  EXPECT_TRUE(hasSaid("removed from the neighbour 35")) << said();
  const auto replayed = replayRun(session);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  const auto exported = exportBundle(session, {}, {}, 1);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->post_op.mesh.triangles.size(), mesh->mesh.triangles.size());

  // The run opens with its neighbours.
  bench_.sessions->open(session);
  settle();
  ASSERT_EQ(bench_.neighbours->list().size(), 1u) << said();
  EXPECT_EQ(bench_.neighbours->list()[0].name, "35");
  EXPECT_GT(bench_.neighbours->list()[0].before_mm3, 0.01);
}

TEST_F(NeighboursTest, OneIsPlacedBesideWhatIsCutAlreadyAndStaysWithAnotherTool) {
  bench_.sessions->open(block("36", {0, 0, 0}));
  settle();
  drill(-1, 0, 2);
  const double before = bench_.document->removedMm3();
  ASSERT_GT(before, 0.01);

  bench_.neighbours->openBeside(folder_.write("text.stl", "no mesh"));
  settle();
  EXPECT_TRUE(hasSaid("text.stl")) << said();
  EXPECT_EQ(bench_.document->removedMm3(), before) << "what is open stays open";
  bench_.neighbours->openBeside(block("the same", {0, 0, 0}));
  settle();
  EXPECT_TRUE(hasSaid("two solids in one place")) << said();

  bench_.neighbours->openBeside(block("35", {6.3, 0, 0}));
  settle();
  until([&] { return !bench_.jobs->running() && bench_.neighbours->list().size() == 1; });
  run(0.1);
  EXPECT_EQ(bench_.neighbours->list()[0].name, "35");
  EXPECT_NEAR(bench_.document->removedMm3(), before, 1e-6);
  EXPECT_EQ(bench_.document->name(), "36");
  drill(kBetween, 0, 3);
  const double off_other = bench_.neighbours->list()[0].removed_mm3;
  EXPECT_GT(off_other, 0.01);

  bench_.tools->add(*findToolFile("round-010", defaultToolFolders()));
  until([&] { return !bench_.jobs->running() && bench_.tools->count() == 2; });
  ASSERT_EQ(bench_.neighbours->list().size(), 1u) << said();
  EXPECT_NEAR(bench_.neighbours->list()[0].before_mm3, off_other, 1e-9);

  bench_.neighbours->workOn(1);
  until([&] { return !bench_.jobs->running() && bench_.document->name() == "35"; });
  ASSERT_EQ(bench_.neighbours->list().size(), 1u) << said();
  EXPECT_EQ(bench_.neighbours->list()[0].name, "36");
  EXPECT_TRUE(bench_.strokes->over(from(6, 0)));
}

TEST_F(NeighboursTest, TakenAwayFromAnUncutObjectItStaysAway) {
  openBoth();
  ASSERT_EQ(bench_.neighbours->list().size(), 1u);
  const std::uint64_t generation = bench_.document->generation();
  ASSERT_TRUE(runAppCommand(context_, "neighbour.remove", std::vector<std::string>{"35"}));
  until([&] { return !bench_.jobs->running() && bench_.document->generation() != generation; });
  EXPECT_TRUE(bench_.neighbours->list().empty()) << said();
  EXPECT_FALSE(bench_.strokes->over(from(6, 0)));

  // Nor does another tool bring it back.
  const std::uint64_t again = bench_.document->generation();
  bench_.sessions->reopen({});
  until([&] { return !bench_.jobs->running() && bench_.document->generation() != again; });
  EXPECT_TRUE(bench_.neighbours->list().empty()) << said();
}

TEST_F(NeighboursTest, BesideACutItIsNotTakenAway) {
  openBoth();
  ASSERT_TRUE(runAppCommand(context_, "saw.plane", std::vector<std::string>{"0", "0.3", "-1", "0", "1", "0"}));
  ASSERT_TRUE(runAppCommand(context_, "plane.cut", std::vector<std::string>{"above"}));
  until([&] { return bench_.steps->done() == 1; });
  const auto gone = runAppCommand(context_, "neighbour.remove", std::vector<std::string>{"35"});
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().code, Error::Code::kUnsupported);
  EXPECT_EQ(bench_.neighbours->list().size(), 1u);
}

TEST_F(NeighboursTest, WhatHardlyFitsTheFrameIsSaid) {
  const struct {
    const char* name;
    Vec3d shift, size;
    double scale;
    const char* expected;
  } cases[] = {{"far", {60, 0, 0}, {6, 4, 3}, 1, "is 54 mm away"},
               {"large", {10, 0, 0}, {6, 4, 3}, 25.4, "Check the units"},
               {"inside", {0.5, 0, -0.2}, {4, 3, 2}, 1, "lies inside the object you cut"}};
  const fs::path object = block("36", {0, 0, 0});
  for (const auto& c : cases) {
    bench_.sessions->openAll({object, block(c.name, c.shift, c.size, c.scale)});
    settle();
    EXPECT_TRUE(hasSaid(c.expected)) << c.name << ": " << said();
  }
}

TEST_F(NeighboursTest, OneJawOfAPairOpensWithTheOtherBeside) {
  const std::array<fs::path, 2> meshes = {block("lower", {0, 0, 0}), block("upper", {0, 0, 3.2})};
  const auto folders = pairFolders(meshes, (folder_.path() / "patient").string());
  ASSERT_TRUE(folders) << folders.error().message();
  BakeOptions options;
  options.unit = "mm";
  options.voxelize.voxel_mm = 0.1;
  const auto baked = bakePair(meshes, *folders, options);
  ASSERT_TRUE(baked) << baked.error().message();

  bench_.sessions->open((*folders)[1]);
  settle();
  ASSERT_EQ(bench_.neighbours->list().size(), 1u) << said();
  EXPECT_EQ(bench_.document->name(), "patient-upper");
  EXPECT_EQ(bench_.neighbours->list()[0].name, "patient-lower");
  EXPECT_TRUE(hasSaid("one jaw of a pair")) << said();

  // Opened together, each is there once.
  bench_.sessions->openAll({(*folders)[0], (*folders)[1]});
  until([&] { return !bench_.jobs->running() && bench_.document->name() == "patient-lower"; });
  EXPECT_EQ(bench_.neighbours->list().size(), 1u) << said();
}

TEST_F(NeighboursTest, AScriptOpensLooksCutsAndExports) {
  const std::string object = block("36", {0, 0, 0}).string(), other = block("35", {6.3, 0, 0}).string();
  Camera camera = *cameraFromView("top");
  AppContext context{.bench = bench_, .camera = camera, .width = 400, .height = 300};
  const auto play = [&](const std::string& script) {
    return runScript(context, folder_.write("script.ks", script), [&] { bench_.update(); });
  };
  auto played = play("file.open \"" + object + "\"\nwait\nfile.open-beside \"" + other +
                     "\"\nwait\nexpect beside 1 1\nexpect pieces 1 1\nneighbour.look 35 ghost\ncut.spare-neighbours " +
                     "0.3\ncut.spare-neighbours off\nexpect beside-removed 0 0\nview.fit\n");
  ASSERT_TRUE(played) << played.error().message() << said();
  // The picture is as wide as both objects. The camera gives the place between them.
  const Vec3d at = camera.target;
  EXPECT_NEAR(at[0], 3.15, 0.2);
  const double x = 200 + (kBetween - at[0]) / camera.mmPerPixel(300);
  played =
      play(fmt::format("cut.press {:.0f} 150\nwait 3\nexpect beside-near -2 0\ncut.release\nwait 0.2\nexpect "
                       "beside-removed 0.005 1\nfile.export-beside \"{}\" 35\nwait\n",
                       x, (folder_.path() / "out.stl").string()));
  ASSERT_TRUE(played) << played.error().message() << said();
  EXPECT_TRUE(fs::exists(folder_.path() / "out.stl"));
  const auto wrong = play("neighbour.look 44 hide\n");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message().find("one of 35"), std::string::npos) << wrong.error().message();
}

// Real scans, if available.
class RealNeighboursTest : public NeighboursTest {
 protected:
  static fs::path data(const std::string& file) {
    const char* given = std::getenv("KERF_DATA");
    const fs::path folder = given ? fs::path(given) : fs::path(kSourceFolder) / ".." / "shared" / "data";
    return folder / file;
  }
};

TEST_F(RealNeighboursTest, TeethOfOnePatientStandWhereTheScanHasThem) {
  const fs::path molar = data("tooth-19-molar-crown-root.stl"), canine = data("tooth-22-canine-crown-root.stl");
  if (!fs::exists(molar)) GTEST_SKIP() << "no data: " << molar << " (set KERF_DATA)";
  bench_.sessions->openAll({molar, canine});
  settle();
  ASSERT_EQ(bench_.neighbours->list().size(), 1u) << said();
  EXPECT_FALSE(hasSaid("same scan frame") || hasSaid("Check the units")) << said();
  const auto shown = bench_.document->scene().shown();
  ASSERT_EQ(shown.size(), 2u);
  const Vec3d apart = shown[0]->surface.bounds().center() - shown[1]->surface.bounds().center();
  EXPECT_GT(apart.norm(), 10) << "where the scan has them";
  EXPECT_LT(apart.norm(), 40);
}

TEST_F(RealNeighboursTest, APairOfJawsOpensAsOneToWorkOnAndTheOtherBeside) {
  const std::array<fs::path, 2> meshes = {data("lower-jaw-scan-01-facecolour.ply"), data("upper-arch-scan-02.stl")};
  if (!fs::exists(meshes[0])) GTEST_SKIP() << "no data: " << meshes[0] << " (set KERF_DATA)";
  const auto folders = pairFolders(meshes, (folder_.path() / "jaws").string());
  ASSERT_TRUE(folders) << folders.error().message();
  BakeOptions options;
  options.voxelize.voxel_mm = 0.25;
  const auto baked = bakePair(meshes, *folders, options);
  ASSERT_TRUE(baked) << baked.error().message();

  bench_.sessions->open((*folders)[0]);
  settle();
  ASSERT_EQ(bench_.neighbours->list().size(), 1u) << said();
  EXPECT_TRUE(hasSaid("one jaw of a pair")) << said();
}

}  // namespace
}  // namespace kerf::neighbours_test
