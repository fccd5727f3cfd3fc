#include "ui/app/workbench/workbench.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "geometry/base/hash.h"
#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/cut/haptic_cut.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/files/run_files.h"
#include "sim/run/report/replay.h"
#include "sim/run/scene/load_scene.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/view_state.h"
#include "ui/app/readout/point_readout.h"
#include "ui/app/script/app_script.h"
#include "ui/app/settings/settings.h"
#include "ui/app/view/scene.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/app/workbench/tools.h"

namespace kerf::workbench_test {
namespace {

namespace fs = std::filesystem;

// A block of 6 x 4 x 3 mm without its underside, like a scan.
fs::path scan(const TemporaryFolder& folder) {
  const fs::path file = folder.path() / "a scan.ply";
  EXPECT_TRUE(writeMesh(file, test::blockMesh(false)));
  return file;
}

class WorkbenchTest : public testing::Test {
 protected:
  WorkbenchOptions options() const {
    WorkbenchOptions out;
    out.data_folder = folder_.path() / "data";
    out.tools = tools_;
    out.voxel_mm = voxel_;
    out.real_time = {.priority = 0, .lock_memory = false};
    return out;
  }
  // Runs a script against a workbench of its own, and ends the session.
  Expected<void> play(const std::string& script) {
    Workbench bench(options());
    Camera camera = *cameraFromView("top");
    AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
    const auto played = runScript(context, folder_.write("script.ks", script), [&] { bench.update(); });
    camera_ = camera;
    notices_ = bench.notices->list();
    bench.jobs->cancel();
    while (bench.jobs->running()) bench.update();
    bench.sessions->close();
    while (bench.jobs->running()) bench.update();
    session_ = bench.document->sessionFolder();
    removed_ = bench.document->removedMm3();
    return played;
  }
  std::string allNotices() const {
    std::string out;
    for (const Notice& notice : notices_) out += notice.text + "\n";
    return out;
  }

  TemporaryFolder folder_;
  std::vector<std::string> tools_ = {"round-014", "round-010"};
  double voxel_ = 0;  // mm; 0: the scan's default
  Camera camera_;
  std::vector<Notice> notices_;
  fs::path session_;
  double removed_ = 0;
};

TEST_F(WorkbenchTest, FromAScanToAFileForThePrinter) {
  const fs::path in = scan(folder_), out = folder_.path() / "cut block.stl";
  const auto played =
      play("file.open \"" + in.string() + "\"  # dropped\nwait\nview.fit\ncut.force 2\ncut.depth 0.4\n" +
           "cut.press 200 150\nwait 3\ncut.drag 230 150\nwait 2\ncut.release\nwait 0.1\n" +
           "expect removed 0.01 9\nedit.undo\nwait 0.2\nexpect removed -1e-9 1e-9\ntool.select round-010\ncut.press "
           "180 150\nwait 3\ncut.release\n" +
           "wait 0.1\nfile.export \"" + out.string() + "\"\nwait\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  EXPECT_NE(allNotices().find("ready to print"), std::string::npos) << allNotices();
  EXPECT_NE(allNotices().find("unit mm"), std::string::npos) << allNotices();

  const auto mesh = readMesh(out);
  ASSERT_TRUE(mesh) << mesh.error().message();
  EXPECT_TRUE(checkMesh(mesh->mesh).print_ready);
  EXPECT_GT(removed_, 0.05);

  // The session: one stroke undone, two tools used.
  const auto replayed = replayRun(session_);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_NEAR(replayed->removed_mm3, removed_, 0.02);
  EXPECT_EQ(readRunManifest(session_)->tool_id, "round-014, round-010");
}

TEST_F(WorkbenchTest, TheSameScanOpensWithoutBakingAgain) {
  const std::string open = "file.open \"" + scan(folder_).string() + "\"\nwait\n";
  const auto times = [&] {
    std::map<fs::path, fs::file_time_type> out;
    for (const auto& entry : fs::directory_iterator(folder_.path() / "data" / "cases"))
      out[entry.path()] = fs::last_write_time(entry.path() / kCaseManifest);
    return out;
  };
  ASSERT_TRUE(play(open)) << allNotices();
  const auto before = times();
  ASSERT_TRUE(play(open)) << allNotices();
  EXPECT_EQ(before.size(), 1u);
  EXPECT_EQ(times(), before);
  EXPECT_FALSE(fs::exists(session_)) << "nothing was cut";
}

TEST_F(WorkbenchTest, WhatCannotBeDoneIsSaidWithItsLine) {
  const std::string file = scan(folder_).string();
  const fs::path text = folder_.write("text.stl", "no mesh");
  const std::pair<std::string, const char*> cases[] = {
      {"fly", "line 1: fly"},
      {"\ncut.press 1 1", "line 2"},
      {"cut.force 90", "0.1 to 8"},
      {"cut.force", "too few"},
      {"file.open", "its path"},
      {"file.open \"" + file, "closing quote"},
      {"file.open /nowhere/a.stl\nwait", "/nowhere/a.stl"},
      {"file.open \"" + text.string() + "\"\nwait", "text.stl"},
      {"file.demo skull", "one of molar"},
      {"file.export a.stl", "not available now"},
      {"file.open \"" + file + "\"\nwait\ncut.press 1 1", "nothing to cut at 1, 1"},
      {"file.open \"" + file + "\"\nwait\ntool.select nonsense", "round-014"},
      {"file.open \"" + file + "\"\nwait\nfile.export /nowhere/a.stl\nwait", "/nowhere"},
      {"file.open \"" + file + "\"\nwait\nfile.export a.xyz\nwait", "a.xyz"},
      {"wait 1", "nothing is open"}};
  for (const auto& [script, words] : cases) {
    const auto played = play(script);
    ASSERT_FALSE(played) << script;
    EXPECT_NE(played.error().message().find(words), std::string::npos) << script << ": " << played.error().message();
  }
}

TEST_F(WorkbenchTest, ACancelledJobLeavesNothing) {
  const auto played = play("file.open \"" + scan(folder_).string() + "\"\njob.cancel\nwait\n");
  EXPECT_TRUE(played) << played.error().message();
  EXPECT_NE(allNotices().find("cancelled"), std::string::npos) << allNotices();
  for (const char* const part : {"sessions", "cases"}) {
    std::error_code ignored;
    const fs::directory_iterator in(folder_.path() / "data" / part, ignored);
    EXPECT_EQ(std::distance(begin(in), end(in)), 0) << part;
  }
}

// Along a path, since the window itself cannot add material.
TEST_F(WorkbenchTest, AFillingIsOfItsMaterialForASessionThatGoesOn) {
  ASSERT_TRUE(play("file.open \"" + scan(folder_).string() +
                   "\"\nwait\nview.fit\ncut.force 2\ncut.depth 0.5\ncut.press 200 150\nwait 1\ncut.release\nwait 1\n"))
      << allNotices();
  const auto in_case = caseOfRun(session_);
  ASSERT_TRUE(in_case) << in_case.error().message();
  const Box3 box = readCaseManifest(*in_case)->box;
  const Vec3d top(box.center()[0], box.center()[1], box.max[2]);
  const fs::path filled = folder_.path() / "filled.run";
  const fs::path path = folder_.write("above.csv", fmt::format("t,x,y,z,qw,qx,qy,qz\n0,{0},{1},{2},1,0,0,0\n"
                                                               "1,{0},{1},{3},1,0,0,0\n",
                                                               top[0], top[1], top[2] + 0.5, top[2] - 0.1));
  HapticCutOptions adding;
  adding.hand = HandKind::kFeed;
  adding.add = "composite";
  const auto added = cutCaseByHand(*in_case, *findToolFile("round-014", defaultToolFolders()), path, filled, adding);
  ASSERT_TRUE(added) << added.error().message();
  const auto filling = [&](const fs::path& run) {
    const auto field = readRunCutField(run);
    const auto materials = readRunMaterials(run);
    EXPECT_TRUE(field && materials) << run;
    const auto object = field && materials ? loadObject(*in_case, &*field, &*materials) : fail({});
    return object ? (*object)->volumes()[static_cast<std::size_t>(Material::kComposite)] : -1;
  };
  const double before = filling(filled);
  ASSERT_NEAR(before, added->summary.added_by_material.at("composite"), 1e-6);
  const auto picture = loadScene(filled);
  ASSERT_TRUE(picture) << picture.error().message();
  const Rgba8 colour = readDefaultMaterials()->find(Material::kComposite)->color;
  EXPECT_GT(std::ranges::count(picture->mesh.face_colors, colour), 10) << "it is seen";

  const auto played = play("replay.open \"" + filled.string() +
                           "\"\nwait\nreplay.end\nwait\nreplay.go-on\nwait\nview.from top\nview.fit\ncut.force 2\n"
                           "cut.depth 0.5\ncut.press 200 150\nwait 2\ncut.release\nwait 1\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  EXPECT_EQ(allNotices().find("WARNING"), std::string::npos) << allNotices();
  EXPECT_GT(removed_, 0.01) << "what was added takes nothing off it";
  const double after = filling(session_);
  EXPECT_LT(after, before - 0.01) << "it was cut";
  EXPECT_GT(after, 0) << "and is still what it was";
  const auto replayed = replayRun(session_);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
}

// A cut severs a bar and one piece is moved. The next day the other one is cut, too.
TEST_F(WorkbenchTest, ASessionGoesOnFromARunWithItsPiecesWhereTheyWere) {
  const fs::path in = folder_.path() / "bar.ply", out = folder_.path() / "bar.stl";
  ASSERT_TRUE(writeMesh(in, test::blockMesh(true, {6, 1.6, 1.2})));
  tools_ = {"disc-22", "round-010"};
  ASSERT_TRUE(play("file.open \"" + in.string() +
                   "\"\nwait\nview.fit\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait 5\ncut.release\nwait 1\n" +
                   "expect pieces 2 2\npiece.choose 2\npiece.rename \"the left\"\npiece.move -2 0 1\nwait 0.1\n"))
      << allNotices();
  const fs::path first = session_;
  const double removed = removed_;

  const auto played =
      play("file.open \"" + first.string() +
           "\"\nwait\nexpect pieces 2 2\nedit.undo\nwait 0.2\nexpect pieces 2 2\npiece.choose \"the left\"\nview.from "
           "top\n" +
           "tool.select round-010\ncut.force 2\ncut.depth 0.4\ncut.press 300 150\nwait 3\ncut.release\nwait 0.2\n" +
           "file.export \"" + out.string() + "\"\nwait\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  EXPECT_NE(allNotices().find("in a new session"), std::string::npos) << allNotices();
  ASSERT_NE(session_, first);
  EXPECT_GT(removed_, removed + 0.02) << "what was removed before counts";

  const auto before = readRunManifest(first), after = readRunManifest(session_);
  ASSERT_TRUE(before && after);
  EXPECT_EQ(after->begin_sha256, before->field_sha256);
  ASSERT_EQ(after->pieces.size(), 2u);
  EXPECT_EQ(after->pieces[1].name, "the left");
  EXPECT_EQ(after->pieces[1].T_case_piece.translation, Vec3d(-2, 0, 1));

  const auto replayed = replayRun(session_);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  const auto earlier = exportBundle(first), later = exportBundle(session_);
  ASSERT_TRUE(earlier && later) << (later ? "" : later.error().message());
  const double more = later->post_op.report.removed_volume_mm3 - earlier->post_op.report.removed_volume_mm3;
  EXPECT_NEAR(more, removed_ - removed, 0.03);
  const auto placed = placedPieces(later->post_op.mesh, later->pieces);
  ASSERT_TRUE(placed) << placed.error().message();
  const auto written = readMesh(out);
  ASSERT_TRUE(written);
  EXPECT_NEAR(signedVolume(written->mesh), signedVolume(together(*placed)), 1e-5);

  // The program is gone: recovery finishes the second session from its log alone.
  const auto field = readRunCutField(session_);
  ASSERT_TRUE(field);
  RunManifest open = *after;
  open.is_open = true;
  open.pieces.clear();
  ASSERT_TRUE(writeRunManifest(session_, open));
  const auto recovered = recoverRun(session_);
  ASSERT_TRUE(recovered) << recovered.error().message();
  EXPECT_EQ(readRunCutField(session_)->stateHash(), field->stateHash());
  ASSERT_EQ(recovered->manifest.pieces.size(), 2u);
  EXPECT_EQ(recovered->manifest.pieces[1].name, "the left");

  // Its initial state is missing or damaged: no replacement is invented.
  fs::remove(session_ / "begin.vdb");
  const auto without = replayRun(session_);
  ASSERT_FALSE(without);
  EXPECT_NE(without.error().message().find("begin.vdb"), std::string::npos) << without.error().message();
}

TEST_F(WorkbenchTest, ASessionWithPiecesIsWatchedAndThenGoneOnWith) {
  const fs::path in = folder_.path() / "bar.ply";
  ASSERT_TRUE(writeMesh(in, test::blockMesh(true, {6, 1.6, 1.2})));
  tools_ = {"disc-22", "round-010"};
  ASSERT_TRUE(play("file.open \"" + in.string() +
                   "\"\nwait\nview.fit\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait 5\ncut.release\nwait 1\n" +
                   "expect pieces 2 2\npiece.choose 2\npiece.rename \"the left\"\npiece.move -2 0 1\nwait 0.1\n" +
                   "tool.select round-010\ncut.depth 0.4\ncut.press 290 150\nwait 2\ncut.release\nwait 0.3\n"))
      << allNotices();
  const fs::path first = session_;
  const double removed = removed_;
  const std::string all = fmt::format("expect same 1 1\nexpect pieces 2 2\nexpect steps 3 3\nexpect removed {} {}\n",
                                      removed - 1e-9, removed + 1e-9);
  const std::string open = "replay.open \"" + first.string() + "\"\nwait\n";

  const auto watched =
      play(open + "expect time 0 0\nexpect pieces 1 1\nexpect removed 0 0\nexpect same -1 -1\nview.fit\n" +
           "view.section\nview.section-deeper 0.1\nview.section\nview.colours depth\nwait\nview.colours tissue\n" +
           "replay.speed fastest\nreplay.play\nwait 1000\nwait\n" + all +  // played to its end
           "replay.jump 1\nwait\nexpect steps 1 1\nexpect same -1 -1\n" +  // back
           "replay.begin\nwait\nexpect time 0 0\nexpect pieces 1 1\nexpect removed 0 0\n" +
           "replay.next\nwait\nexpect steps 1 1\nreplay.next\nwait\nexpect pieces 2 2\nexpect steps 2 2\n" +
           "replay.previous\nwait\nexpect steps 1 1\nreplay.end\nwait\n" + all +  // forth
           "replay.time 1\nwait\nexpect time 1 1\nreplay.speed 2\nreplay.play\nwait 0.5\nreplay.pause\nwait\n" +
           "expect time 1.4 3\nprint\nreplay.end\nwait\nreplay.go-on\nwait\nexpect pieces 2 2\n" +
           fmt::format("expect removed {} {}\n", removed - 0.03, removed + 0.03) +  // as the run's field counts
           "tool.select round-010\ncut.depth 0.4\ncut.press 300 150\nwait 2\ncut.release\nwait 0.3\n");
  ASSERT_TRUE(watched) << watched.error().message() << allNotices();
  EXPECT_NE(allNotices().find("replayed: the same"), std::string::npos) << allNotices();
  const fs::path second = session_;
  ASSERT_NE(second, first);

  // A session that began in pieces, at their moved places.
  const auto again = play("replay.open \"" + second.string() +
                          "\"\nwait\nexpect pieces 2 2\nreplay.end\nwait\nexpect same 1 1\nexpect pieces 2 2\n" +
                          fmt::format("expect removed {} {}\n", removed_ - 1e-9, removed_ + 1e-9) +
                          "replay.close\nwait\nexpect pieces 0 0\n");
  ASSERT_TRUE(again) << again.error().message() << allNotices();

  const std::pair<std::string, const char*> refused[] = {
      {open + "replay.go-on\nwait", "nothing is cut up to there"},
      {open + "replay.jump 4", "0 to 3"},
      {open + "replay.speed 40", "0.25 to 16"},
      {open + "cut.press 200 150", "not available now"},
      {open + "replay.end\nwait\npiece.next", "not available now"},
      {"replay.play", "not available now"},
      {"replay.open \"" + in.string() + "\"\nwait", "bar.ply"},
  };
  for (const auto& [script, expected] : refused) {
    const auto played = play(script + "\n");
    ASSERT_FALSE(played) << script;
    EXPECT_NE(played.error().message().find(expected), std::string::npos) << played.error().message();
  }
}

// Exports that would lose data: the scan by a piece's name, the scan from a run, one of two pieces.
TEST_F(WorkbenchTest, AnExportOfPiecesWritesOverNoScanAndNoOtherPiece) {
  const fs::path in = folder_.path() / "bar-piece-1.obj";
  ASSERT_TRUE(writeMesh(in, test::blockMesh(true, {6, 1.6, 1.2})));
  const auto before = sha256OfFile(in);
  tools_ = {"disc-22"};
  const std::string cut = "file.open \"" + in.string() +
                          "\"\nwait\nview.fit\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait "
                          "5\ncut.release\nwait 1\nexpect pieces 2 2\n";
  const auto each = play(cut + "file.export-each \"" + (folder_.path() / "bar.obj").string() + "\"\nwait\n");
  ASSERT_FALSE(each);
  EXPECT_NE(each.error().message().find("never overwrites"), std::string::npos) << each.error().message();
  EXPECT_EQ(*sha256OfFile(in), *before);
  EXPECT_FALSE(fs::exists(folder_.path() / "bar-piece-2.obj")) << "nothing is written before all is checked";

  const fs::path first = session_;
  const auto from_run = play("file.open \"" + first.string() + "\"\nwait\nfile.export \"" + in.string() + "\"\nwait\n");
  ASSERT_FALSE(from_run);
  EXPECT_EQ(*sha256OfFile(in), *before);
  EXPECT_FALSE(fs::exists(session_)) << "it was only opened";

  const auto names = play("file.open \"" + first.string() + "\"\nwait\npiece.choose 2\npiece.rename \"piece 1\"\n");
  ASSERT_FALSE(names);
  EXPECT_NE(names.error().message().find("another piece"), std::string::npos) << names.error().message();
  EXPECT_FALSE(play("file.open \"" + first.string() + "\"\nwait\npiece.choose 2\npiece.rename 7\n"));

  // A plan refers to the original scan: at a moved piece it would saw air.
  const auto planned = play("file.open \"" + first.string() +
                            "\"\nwait\npiece.choose 2\npiece.move 1 0 2\nwait 0.1\nsaw.plane 2 0 -0.5 1 0 0\n");
  ASSERT_FALSE(planned);
  EXPECT_NE(planned.error().message().find("a piece was moved"), std::string::npos) << planned.error().message();
}

TEST_F(WorkbenchTest, ASessionThatAddsNothingToARunLeavesNone) {
  ASSERT_TRUE(play("file.open \"" + scan(folder_).string() + "\"\nwait\nview.fit\ncut.press 200 150\nwait 3\n"));
  ASSERT_TRUE(isRun(session_));
  const fs::path first = session_;
  ASSERT_TRUE(play("file.open \"" + first.string() + "\"\nwait\nwait 0.2\n")) << allNotices();
  EXPECT_NE(session_, first);
  EXPECT_FALSE(fs::exists(session_));
  EXPECT_TRUE(isRun(first));
}

TEST_F(WorkbenchTest, WhatIsExportedHasTheNamesOfItsScan) {
  const fs::path in = folder_.path() / "row.obj", out = folder_.path() / "out.3mf";
  Mesh row = test::blockMesh(true), other = test::blockMesh(true);
  for (Vec3d& p : other.vertices) p.x() += 10;
  append(row, other);
  ASSERT_TRUE(writeMesh(in, row, {.objects = {{"tooth 36", 0}, {"gingiva", 12}}}));
  const auto played = play("file.open \"" + in.string() + "\"\nwait\nfile.export \"" + out.string() + "\"\nwait\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  const auto back = readMesh(out);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->objects, (std::vector<NamedPart>{{"tooth 36", 0}, {"gingiva", 12}}));

  // After a move, the solids keep theirs. A name given by the user takes precedence.
  std::string script = "file.open \"" + in.string() + "\"\nwait\n";
  const auto exportAfter = [&](const std::string& act) {
    const fs::path file = folder_.path() / fmt::format("{}.3mf", act.substr(6, 4));
    script += act + "\nwait\nfile.export \"" + file.string() + "\"\nwait\n";
    return file;
  };
  const fs::path moved = exportAfter("piece.choose 1\npiece.move 5 0 0"), named = exportAfter("piece.rename Bridge"),
                 undone = exportAfter("piece.put-back");
  const auto again = play(script);
  ASSERT_TRUE(again) << again.error().message() << allNotices();
  const auto objectsIn = [](const fs::path& file) { return readMesh(file).value_or(MeshFile{}).objects; };
  const std::vector<NamedPart> bridge{{"Bridge", 0}};
  EXPECT_EQ(objectsIn(moved), back->objects);
  EXPECT_EQ(objectsIn(named), bridge);
  EXPECT_EQ(objectsIn(undone), bridge) << "also where it was not moved";
}

TEST_F(WorkbenchTest, TheScanThatWasOpenedIsNeverWrittenOver) {
  const fs::path in = scan(folder_);
  const auto before = sha256OfFile(in);
  const auto played = play("file.open \"" + in.string() + "\"\nwait\nfile.export \"" + in.string() + "\"\nwait\n");
  ASSERT_FALSE(played);
  EXPECT_NE(played.error().message().find("never overwrites"), std::string::npos) << played.error().message();
  EXPECT_EQ(*sha256OfFile(in), *before);
}

TEST_F(WorkbenchTest, AStrokeStopsShortOfThePulp) {
  tools_ = {"round-014"};
  voxel_ = 0.15;
  const std::string begin = "file.demo molar\nwait\nview.top\nview.fit\ncut.force 1.2\ncut.depth 5\n";
  ASSERT_TRUE(play(begin + "cut.stop-short 3.3\ncut.press 200 150\nwait 8\nexpect near 3.27 3.35\ncut.stop-short off\n"
                           "wait 4\nexpect near 0 3.25\ncut.release\n"))
      << allNotices();
  const auto replayed = replayRun(session_);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;

  EXPECT_FALSE(play("cut.stop-short 6\n"));
  EXPECT_FALSE(play("cut.stop-short near\n"));
}

TEST_F(WorkbenchTest, ADrillThatTurnsBackwardsTakesNothingAndATurbineRefuses) {
  tools_ = {"round-014", "drill-20"};
  const std::string open = "file.open \"" + scan(folder_).string() + "\"\nwait\nview.fit\ncut.force 4\n";
  const std::string stroke = "cut.press 200 150\nwait 2\ncut.release\nwait 0.2\n";
  const auto played = play(open + "tool.select drill-20\ncut.reverse on\n" + stroke + "expect removed 0 0\n" +
                           "cut.reverse\n" + stroke + "expect removed 0.1 100\n");
  EXPECT_TRUE(played) << played.error().message() << allNotices();

  // The next tool starts forwards.
  const auto next = play(open + "tool.select drill-20\ncut.reverse on\ntool.select round-014\n" + stroke +
                         "expect removed 0.1 100\n");
  EXPECT_TRUE(next) << next.error().message();

  // The next opened scan too.
  const auto again = play(open + "tool.select drill-20\ncut.reverse on\n" + open + stroke + "expect removed 0.1 100\n");
  EXPECT_TRUE(again) << again.error().message();

  const auto refused = play(open + "cut.reverse on\n");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("a turbine has no reverse"), std::string::npos) << refused.error().message();
}

TEST_F(WorkbenchTest, TheDepthOfTheTipThePaceOfTheLoopAndWhatAPieceLostAreKnown) {
  tools_ = {"round-010", "disc-22"};
  const fs::path in = folder_.path() / "bar.ply";
  ASSERT_TRUE(writeMesh(in, test::blockMesh(true, {6, 1.6, 1.2})));
  Workbench bench(options());
  Camera camera = *cameraFromView("top");
  AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
  const auto play = [&](const std::string& script) {
    return runScript(context, folder_.write("s.ks", script), [&] { bench.update(); });
  };
  const auto drilled = play("file.open \"" + in.string() +
                            "\"\nwait\nview.fit\ncut.force 2\ncut.depth 0.4\nexpect tip 0 0\ncut.press 290 150\n" +
                            "wait 4\nexpect depth 0.3 0.45\nexpect tip 0.3 0.45\nexpect loop 1 1200\nprint\n");
  ASSERT_TRUE(drilled) << drilled.error().message();
  EXPECT_NEAR(*bench.monitor->tipDepth(), *bench.strokes->depthNow(), 0.02);
  ASSERT_TRUE(play("cut.release\nwait 0.3\n"));
  EXPECT_FALSE(bench.monitor->tipDepth()) << "nobody leads the tool";

  // Sawn through on the left: the earlier drilled volume stays with the first piece.
  const double before = bench.document->removedMm3();
  ASSERT_TRUE(
      play("tool.select disc-22\ncut.force 3\ncut.depth 2.2\ncut.press 150 150\nwait 5\ncut.release\nwait 1\n"
           "expect pieces 2 2\ntool.select round-010\ncut.depth 0.3\ncut.force 2\ncut.press 120 150\nwait 2\n"
           "cut.release\nwait 0.3\n"));
  double sum = 0;
  for (const SceneObject* piece : bench.document->scene().shown()) {
    EXPECT_GT(piece->removed_mm3, 0.005) << piece->name;
    sum += piece->removed_mm3;
  }
  EXPECT_GT(sum, before + 0.1);
  EXPECT_NEAR(sum, bench.document->removedMm3(), 1e-9);
}

TEST_F(WorkbenchTest, ADryStrokeIsWarm) {
  tools_ = {"round-014"};
  voxel_ = 0.15;
  const std::string begin =
      "file.demo molar\nwait\nview.top\nview.fit\ncut.force 1.2\ncut.depth 5\nexpect warm 36.9 37.1\n";
  const std::string stroke = "cut.press 200 150\nwait 2\nexpect removed 0.01 5\n";
  EXPECT_TRUE(play(begin + stroke + "expect warm 30 50\n")) << allNotices();
  EXPECT_TRUE(play(begin + "cut.irrigation 0\n" + stroke + "expect warm 60 400\n")) << allNotices();
  EXPECT_FALSE(play("cut.irrigation 101\n"));
}

// Neither the last stroke, still being cut, nor an export blocks the window's thread.
TEST_F(WorkbenchTest, AnExportDoesNotHoldUpTheWindow) {
  Workbench bench(options());
  Camera camera = *cameraFromView("top");
  AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
  const fs::path out = folder_.path() / "cut.stl";
  const std::string script =
      "file.open \"" + scan(folder_).string() + "\"\nwait\nview.fit\ncut.press 200 150\nwait 0.5\n";
  ASSERT_TRUE(runScript(context, folder_.write("a.ks", script), [&] { bench.update(); }));

  bench.results->exportTo(out);
  ASSERT_TRUE(bench.jobs->running());
  EXPECT_FALSE(fs::exists(out)) << "nothing is waited for";
  bench.strokes->press(rayUnder(camera, 220, 150, 400, 300));  // and the cut goes on
  while (bench.jobs->running()) bench.update();
  bench.strokes->release();
  ASSERT_TRUE(fs::exists(out)) << bench.notices->list().back().text;
  EXPECT_NE(bench.notices->list().back().text.find("ready to print"), std::string::npos)
      << bench.notices->list().back().text;

  bench.strokes->press(rayUnder(camera, 200, 150, 400, 300));
  bench.results->exportTo(folder_.path() / "no.stl");
  bench.jobs->cancel();
  while (bench.jobs->running()) bench.update();
  EXPECT_FALSE(fs::exists(folder_.path() / "no.stl")) << "cancelled while it waited";
}

// The session ends at the place chosen on the timeline, even if it ends at once.
TEST_F(WorkbenchTest, ASessionThatEndsInAJumpEndsWhereThatLeads) {
  Workbench bench(options());
  Camera camera = *cameraFromView("top");
  AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
  std::string script = "file.open \"" + scan(folder_).string() + "\"\nwait\nview.fit\ncut.force 2\n";
  for (const int x : {150, 200, 250}) script += fmt::format("cut.press {} 150\nwait 1.5\ncut.release\nwait 0.1\n", x);
  const auto played = runScript(context, folder_.write("a.ks", script), [&] { bench.update(); });
  ASSERT_TRUE(played) << played.error().message();
  const double all = bench.document->removedMm3();
  ASSERT_EQ(bench.steps->done(), 3u);

  // A step without a report precedes the jump.
  const SceneObject& block = *bench.document->scene().shown().front();
  bench.pieces->move(block.id, {Eigen::Quaterniond::Identity(), {0, 0, 1}});
  ASSERT_TRUE(bench.steps->goToStep(1));
  const std::uint64_t sent_by = bench.document->report().tick + 300;
  while (bench.document->report().tick < sent_by) bench.update();
  EXPECT_EQ(bench.steps->done(), 1u);
  ASSERT_TRUE(bench.steps->goToStep(3));
  ASSERT_TRUE(bench.steps->goToStep(1));
  bench.sessions->close();
  while (bench.jobs->running()) bench.update();
  const auto replayed = replayRun(bench.document->sessionFolder());
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_GT(replayed->removed_mm3, 0.1 * all);
  EXPECT_LT(replayed->removed_mm3, 0.6 * all);
}

TEST_F(WorkbenchTest, AnExportRightAfterAnUndoIsWithoutTheStroke) {
  const fs::path out = folder_.path() / "whole.stl";
  const auto played = play("file.open \"" + scan(folder_).string() +
                           "\"\nwait\nview.fit\ncut.force 2\ncut.press 200 150\nwait 3\ncut.release\nwait 0.1\n" +
                           "expect removed 0.01 9\nedit.undo\nfile.export \"" + out.string() + "\"\nwait\n");
  ASSERT_TRUE(played) << played.error().message();
  EXPECT_NE(allNotices().find("removed 0.000 mm3"), std::string::npos) << allNotices();
}

TEST_F(WorkbenchTest, WhatCannotBeOpenedLeavesTheSessionAlone) {
  const fs::path text = folder_.write("text.stl", "no mesh");
  Workbench bench(options());
  const auto work = [&] {
    do bench.update();
    while (bench.jobs->running());
  };
  bench.sessions->open(scan(folder_));
  work();
  ASSERT_TRUE(bench.document->isOpen());
  const std::string name = bench.document->name();
  bench.sessions->open(text);
  work();
  EXPECT_TRUE(bench.document->isOpen());
  EXPECT_EQ(bench.document->name(), name);
  EXPECT_TRUE(bench.notices->list().back().is_error);
}

TEST_F(WorkbenchTest, ToolsOfOneNameAreKeptApart) {
  WorkbenchOptions twice = options();
  const fs::path other = folder_.path() / "round-014.toml";
  fs::copy_file(*findToolFile("round-014", defaultToolFolders()), other);
  twice.tools = {"round-014", other.string()};
  Workbench bench(twice);
  bench.sessions->open(scan(folder_));
  do bench.update();
  while (bench.jobs->running());
  EXPECT_TRUE(bench.document->isOpen()) << bench.notices->list().back().text;
  EXPECT_EQ(bench.tools->count(), 2u);
}

TEST_F(WorkbenchTest, TheDefaultRackIsThere) {
  WorkbenchOptions plain = options();
  plain.tools.clear();
  const Workbench bench(plain);
  EXPECT_TRUE(bench.notices->list().empty()) << bench.notices->list().front().text;
}

TEST_F(WorkbenchTest, WhatWasOpenedIsOpenedAgainByTheListOfRecentFiles) {
  WorkbenchOptions remembering = options();
  remembering.keeps_recent = true;
  const fs::path file = scan(folder_);
  {
    Workbench bench(remembering);
    bench.sessions->open(file);
    do bench.update();
    while (bench.jobs->running());
    ASSERT_EQ(bench.history->recent().list().size(), 1u);
  }
  Workbench bench(remembering);
  Camera camera;
  AppContext context{.bench = bench, .camera = camera};
  const auto play = [&](const std::string& script) {
    return runScript(context, folder_.write("script.ks", script), [&] { bench.update(); });
  };
  ASSERT_TRUE(play("recent.open\nwait\nimport.start\nwait\n"));
  EXPECT_EQ(bench.document->source(), file);
  EXPECT_FALSE(play("recent.forget\n")) << "which one is to be said";
  EXPECT_FALSE(play("recent.forget 2\n"));
  ASSERT_TRUE(play("recent.forget 1\n"));
  EXPECT_TRUE(bench.history->recent().list().empty());
  EXPECT_TRUE(fs::exists(file));
}

TEST_F(WorkbenchTest, ALostLogIsDeletedOnlyWhenThatIsAskedFor) {
  ASSERT_TRUE(play("file.open \"" + scan(folder_).string() + "\"\nwait\nview.fit\ncut.press 200 150\nwait 2\n"));
  // As left by a killed program: the manifest marks the session as open.
  auto manifest = readRunManifest(session_);
  ASSERT_TRUE(manifest);
  manifest->is_open = true;
  ASSERT_TRUE(writeRunManifest(session_, *manifest));

  Workbench bench(options());
  Camera camera;
  AppContext context{.bench = bench, .camera = camera};
  ASSERT_EQ(bench.history->lostSessions().size(), 1u);
  EXPECT_GT(bench.history->bytesOfLost(0), 1000u);
  const std::vector<std::string> number{"1"}, both{"1", "delete"};
  const auto refused = runAppCommand(context, "session.forget", number);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("session.recover"), std::string::npos);
  EXPECT_TRUE(fs::exists(session_ / "session.kerflog"));

  ASSERT_TRUE(runAppCommand(context, "session.forget", both));
  EXPECT_FALSE(fs::exists(session_));
  EXPECT_TRUE(bench.history->lostSessions().empty());
}

TEST_F(WorkbenchTest, WhatIsSetByCommandsIsKept) {
  Workbench bench(options());
  Camera camera;
  SettingsFile settings(folder_.path() / "config");
  AppContext context{.bench = bench, .camera = camera, .settings = &settings};
  const auto play = [&](const std::string& script) {
    return runScript(context, folder_.write("script.ks", script), [&] { bench.update(); });
  };
  ASSERT_TRUE(
      play("view.theme dark\nview.scale 1.5\nview.larger\nview.hints off\ncut.force 2\ncut.depth 1\n"
           "settings.push\nsettings.show\nsound.volume 80\nsound.mute\n"));
  EXPECT_TRUE(context.panels["settings"]);
  const Settings kept = SettingsFile(folder_.path() / "config").values;
  EXPECT_EQ(kept.theme, Theme::kDark);
  EXPECT_NEAR(kept.ui_scale, 1.6, 1e-9);
  EXPECT_TRUE(kept.are_hints_dismissed);
  EXPECT_EQ(kept.force_N, 2);
  EXPECT_EQ(kept.depth_mm, 1);
  EXPECT_EQ(kept.sound_volume, 80);
  EXPECT_TRUE(kept.is_muted);
  ASSERT_TRUE(play("sound.mute off\n"));
  EXPECT_FALSE(settings.values.is_muted);
  EXPECT_FALSE(play("sound.volume 101\n"));

  EXPECT_FALSE(play("view.theme pink\n"));
  EXPECT_FALSE(play("view.scale 9\n"));
  EXPECT_FALSE(play("view.hints maybe\n"));
  ASSERT_TRUE(play("view.theme\n"));
  EXPECT_EQ(SettingsFile(folder_.path() / "config").values.theme, Theme::kLight);
  AppContext without{.bench = bench, .camera = camera};
  EXPECT_FALSE(runAppCommand(without, "view.larger")) << "nothing would be kept";
}

TEST(AppCommands, TheTableIsSound) {
  std::set<std::string_view> ids, keys;
  const std::set<std::string_view> shared{"Esc", "Enter", "Ctrl+Z"};  // of the screen: leaves, goes on, takes back
  for (const AppCommand& command : appCommands()) {
    EXPECT_TRUE(ids.insert(command.id).second) << command.id;
    if (!command.key.empty() && !shared.contains(command.key)) {
      EXPECT_TRUE(keys.insert(command.key).second) << command.key;
    }
    EXPECT_EQ(command.menu.empty(), command.label.empty()) << command.id;
    EXPECT_TRUE(command.description.ends_with('.')) << command.id;
    EXPECT_EQ(findAppCommand(command.id), &command);
  }
}

TEST(AppCommands, ARayIsUnderItsPixel) {
  Camera camera = *cameraFromView("35,20");
  camera.target = {1, 2, 3};
  camera.half_height = 10;
  const Ray middle = rayUnder(camera, 200, 150, 400, 300);
  EXPECT_NEAR((camera.target - middle.origin).cross(middle.direction).norm(), 0, 1e-9);
  const Ray right = rayUnder(camera, 215, 150, 400, 300);
  EXPECT_NEAR((right.origin - middle.origin - 15 * camera.mmPerPixel(300) * camera.right()).norm(), 0, 1e-9);
}

// A bar of 6 x 1.6 x 1.2 mm, cut through by a disc.
TEST_F(WorkbenchTest, APieceIsMovedCutFurtherTakenBackAndExported) {
  const fs::path in = folder_.path() / "bar.ply", out = folder_.path() / "bar.stl";
  ASSERT_TRUE(writeMesh(in, test::blockMesh(true, {6, 1.6, 1.2})));
  tools_ = {"disc-22", "round-010"};
  const auto played = play(
      "file.open \"" + in.string() + "\"\nwait\nview.fit\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait 5\n" +
      "cut.release\nwait 1\nexpect pieces 2 2\npiece.choose 2\npiece.rename \"the left\"\n" +
      "piece.move -2 1 0.5\nwait 0.1\npiece.turn Z 30\nwait 0.1\n" +
      // The moved piece is cut at its new place: in a picture of the whole, the left piece is on the left.
      "view.from top\ntool.select round-010\ncut.depth 0.4\ncut.press 90 130\nwait 3\ncut.release\nwait 0.2\nprint\n" +
      "file.export \"" + out.string() + "\"\nwait\nfile.export-each \"" + out.string() + "\"\nwait\n" +
      "file.export-put-back \"" + (folder_.path() / "back.stl").string() + "\"\nwait\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  EXPECT_EQ(allNotices().find("NOT ready"), std::string::npos) << allNotices();

  const auto moved = readMesh(out), left = readMesh(folder_.path() / "bar-the-left.stl"),
             right = readMesh(folder_.path() / "bar-piece-1.stl"), back = readMesh(folder_.path() / "back.stl");
  ASSERT_TRUE(moved && left && right && back);
  EXPECT_NEAR(signedVolume(moved->mesh), signedVolume(left->mesh) + signedVolume(right->mesh), 1e-6);
  EXPECT_NEAR(signedVolume(moved->mesh), signedVolume(back->mesh), 1e-4);
  EXPECT_LT(bounds(moved->mesh).min[0], -4);
  EXPECT_NEAR(bounds(back->mesh).min[0], -3, 1e-6);
  EXPECT_NEAR(bounds(right->mesh).max[0], 3, 1e-6);
  EXPECT_EQ(checkMesh(back->mesh).pieces, 2u);

  // The run: the same bits, and the same files from the functions of the command line.
  const auto replayed = replayRun(session_);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
  EXPECT_EQ(replayed->objects, 2u);
  EXPECT_NEAR(replayed->removed_mm3, removed_, 1e-3);
  const auto exported = exportBundle(session_);
  ASSERT_TRUE(exported) << exported.error().message();
  ASSERT_EQ(exported->pieces.size(), 2u);
  EXPECT_EQ(exported->pieces[1].name, "the left");
  const auto placed = placedPieces(exported->post_op.mesh, exported->pieces);
  ASSERT_TRUE(placed) << placed.error().message();
  EXPECT_NEAR(signedVolume((*placed)[1].mesh), signedVolume(left->mesh), 1e-6);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(bounds((*placed)[1].mesh).min[axis], bounds(left->mesh).min[axis], 1e-6);
}

TEST_F(WorkbenchTest, APieceIsMovedByItsNameWhicheverIsChosen) {
  const fs::path in = folder_.path() / "bar.ply";
  ASSERT_TRUE(writeMesh(in, test::blockMesh(true, {6, 1.6, 1.2})));
  tools_ = {"disc-22"};
  const auto played =
      play("file.open \"" + in.string() +
           "\"\nwait\nview.fit\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait 5\ncut.release\n" +
           "wait 1\nexpect pieces 2 2\npiece.choose 2\npiece.rename \"the left\"\npiece.choose 1\n" +
           "piece.move -2 1 0.5 \"the left\"\nwait 0.2\npiece.move 0 0 3 1\npiece.turn Z 10 1\nwait 0.2\n" +
           "piece.put-back \"piece 1\"\nwait 0.2\npiece.move 1 0 0 \"the right\"\n");
  ASSERT_FALSE(played) << "there is none of that name";
  EXPECT_NE(played.error().message().find("1 to 2, or one of piece 1, the left"), std::string::npos)
      << played.error().message();
  const auto manifest = readRunManifest(session_);
  ASSERT_TRUE(manifest) << manifest.error().message();
  ASSERT_EQ(manifest->pieces.size(), 2u);
  EXPECT_FALSE(manifest->pieces[0].isMoved()) << "it was put back";
  EXPECT_EQ(manifest->pieces[1].name, "the left");
  EXPECT_NEAR((manifest->pieces[1].T_case_piece.translation - Vec3d(-2, 1, 0.5)).norm(), 0, 1e-9);
  EXPECT_TRUE(replayRun(session_)->is_same);
}

TEST_F(WorkbenchTest, UndoTakesBackAMoveThenThePiecesAndRedoBringsThemAgain) {
  const fs::path in = folder_.path() / "bar.ply";
  ASSERT_TRUE(writeMesh(in, test::blockMesh(true, {6, 1.6, 1.2})));
  tools_ = {"disc-22"};
  const auto played =
      play("file.open \"" + in.string() +
           "\"\nwait\nview.fit\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait 5\ncut.release\n" +
           "wait 1\nexpect pieces 2 2\npiece.choose 2\npiece.move 0 0 3\nwait 0.2\nedit.undo\nwait 0.3\n" +
           "expect pieces 2 2\nexpect removed 0.3 2\nedit.undo\nwait 1\nexpect pieces 1 1\n" +
           "expect removed -1e-9 1e-9\nedit.redo\nwait 1\nexpect pieces 2 2\nexpect removed 0.3 2\n");
  ASSERT_TRUE(played) << played.error().message() << allNotices();
  const auto manifest = readRunManifest(session_);
  ASSERT_TRUE(manifest) << manifest.error().message();
  ASSERT_EQ(manifest->pieces.size(), 2u);
  EXPECT_FALSE(manifest->pieces[1].isMoved()) << "the move was taken back";
  EXPECT_TRUE(replayRun(session_)->is_same);
}

// Workflow of a tool maker: drops a new file into an open session, then changes it, then breaks it.
TEST_F(WorkbenchTest, AToolThatIsDroppedIsInHandAndTheCutGoesOn) {
  const std::string text =
      "format = \"kerf-tool\"\nversion = 1\nid = \"mine\"\nname = \"My bur\"\ndescription = \"a round bur\"\n"
      "kind = \"bur\"\nshape = \"round\"\nhead_diameter = 2.2\nneck_diameter = 0.9\nneck_length = 3.6\n"
      "shank_diameter = 1.6\nshank_length = 10\n";
  const auto known = readTool(*findToolFile("round-014", defaultToolFolders()));
  ASSERT_TRUE(known);
  const fs::path file = folder_.write("mine.toml", text);
  ASSERT_TRUE(readTool(file)) << readTool(file).error().message();

  Workbench bench(options());
  Camera camera = *cameraFromView("top");
  AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
  const auto run = [&](const std::string& script) {
    return runScript(context, folder_.write("s.ks", script), [&] { bench.update(); });
  };
  ASSERT_TRUE(run("file.open \"" + scan(folder_).string() +
                  "\"\nwait\nview.fit\ncut.press 200 150\nwait 2\ncut.release\n" + "wait 0.2\n"));
  const double removed = bench.document->removedMm3();
  EXPECT_GT(removed, 0.01);
  const std::uint64_t before = bench.document->generation();
  ASSERT_EQ(bench.views->tissues().all().size(), 1u);
  const std::string tissue = bench.views->tissues().all()[0].id;
  ASSERT_TRUE(run("view.colours depth\nwait\nview.tissue " + tissue + " ghost\n"));

  bench.sessions->open(file);  // as a drop does
  ASSERT_TRUE(run("wait\nwait 0.2\n"));
  ASSERT_TRUE(bench.document->isOpen());
  EXPECT_EQ(bench.tools->at(bench.tools->inHand()).id, "mine");
  EXPECT_NEAR(bench.document->removedMm3(), removed, 0.02) << "what was cut is cut";
  EXPECT_GT(bench.document->generation(), before);
  EXPECT_TRUE(bench.document->keepsView());
  EXPECT_EQ(bench.views->tissues().all()[0].look, TissueLook::kGhost) << "what was chosen to be seen is";
  EXPECT_EQ(bench.views->tissues().choices().colours, SurfaceColours::kDepth);
  ASSERT_TRUE(run("view.tissues-all\nview.colours tissue\n"));
  EXPECT_EQ(bench.document->name(), "a scan");
  ASSERT_TRUE(run("cut.press 150 150\nwait 3\ncut.release\nwait 0.2\n"));
  EXPECT_GT(bench.document->removedMm3(), removed + 0.01);

  // Changed: the program reloads it.
  folder_.write("mine.toml", std::string(text).replace(text.find("2.2"), 3, "1.9"));
  fs::last_write_time(file, fs::file_time_type::clock::now() + std::chrono::seconds(5));
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < until && !(bench.document->isOpen() && !bench.jobs->running() &&
                                                       bench.tools->at(bench.tools->inHand()).head_diameter_mm == 1.9))
    bench.update();
  ASSERT_TRUE(bench.document->isOpen());
  EXPECT_EQ(bench.tools->at(bench.tools->inHand()).head_diameter_mm, 1.9);

  const auto again = run("wait\nwait 0.2\ncut.press 250 150\nwait 2\ncut.release\nwait 0.2\n");
  ASSERT_TRUE(again) << again.error().message();

  // Broken: a notice gives the line, and the tool in hand stays.
  folder_.write("mine.toml", text + "head_diamter = 3\n");
  const auto refused = run("tool.add \"" + file.string() + "\"\n");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("head_diamter"), std::string::npos) << refused.error().message();
  EXPECT_EQ(bench.tools->at(bench.tools->inHand()).head_diameter_mm, 1.9);
  bench.sessions->close();
  while (bench.jobs->running()) bench.update();
  const auto replayed = replayRun(bench.document->sessionFolder());
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
}

TEST_F(WorkbenchTest, ThePointUnderTheCursorIsSaidInTheFrameOfTheScan) {
  Workbench bench(options());
  Camera camera = *cameraFromView("top");
  std::string copied;
  AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
  context.set_clipboard = [&](const std::string& text) { copied = text; };
  const auto run = [&](const std::string& script) {
    return runScript(context, folder_.write("s.ks", script), [&] { bench.update(); });
  };
  const fs::path file = folder_.path() / "block.ply";
  ASSERT_TRUE(writeMesh(file, test::blockMesh(true)));
  ASSERT_TRUE(run("file.open \"" + file.string() + "\"\nwait\nview.fit\n"));
  const Ray ray{{1.23, -0.4, 20}, -Vec3d::UnitZ()};
  const auto readout = readoutAt(bench, ray);
  ASSERT_TRUE(readout);
  EXPECT_LT((readout->point - Vec3d(1.23, -0.4, 0)).norm(), 0.01);
  EXPECT_GT(readout->normal[2], 0.999);
  ASSERT_TRUE(readout->thickness_mm);
  EXPECT_NEAR(*readout->thickness_mm, 3, 0.01);
  EXPECT_TRUE(readout->tissue.empty()) << "a scan says nothing of tissues";
  ASSERT_TRUE(readout->T_scan_tool);
  EXPECT_LT((readout->T_scan_tool->translation - readout->point).norm(), 1e-6) << "a round bur stands on its tip";
  EXPECT_FALSE(readoutAt(bench, {{9, 9, 20}, -Vec3d::UnitZ()}));

  // Cut open 1 mm below its top, the block shows its inside, which the pointer ignores.
  bench.views->section = Plane{{0, 0, -1}, Vec3d::UnitZ()};
  EXPECT_FALSE(readoutAt(bench, ray));
  EXPECT_FALSE(bench.strokes->over(ray));
  EXPECT_TRUE(readoutAt(bench, {{1.23, -20, -2}, Vec3d::UnitY()})) << "what is left is still there";
  EXPECT_FALSE(readoutAt(bench, {{1.23, -20, -0.5}, Vec3d::UnitY()})) << "this lies in what is taken away";
  ASSERT_TRUE(run("view.section\n"));
  EXPECT_FALSE(bench.views->section);
  ASSERT_TRUE(run("view.section 200 150\nview.section-deeper 0.5\n"));
  ASSERT_TRUE(bench.views->section);
  EXPECT_NEAR(bench.views->section->height({0, 0, 0}), 0.5, 0.01);
  ASSERT_TRUE(run("view.section\n"));

  ASSERT_TRUE(run("point.copy 200 150\n"));
  EXPECT_NE(copied.find("3.00 mm thick"), std::string::npos) << copied;
  ASSERT_TRUE(run("point.copy-row 200 150\n"));
  EXPECT_EQ(std::count(copied.begin(), copied.end(), ','), 7) << copied;
  EXPECT_FALSE(run("point.copy 2 2\n"));
}

TEST(Measure, DistancesAnglesAndTheirSum) {
  Measure measure;
  EXPECT_TRUE(measure.text().empty());
  measure.add({0, 0, 0});
  EXPECT_TRUE(measure.text().empty());
  measure.add({3, 4, 0});
  EXPECT_EQ(measure.text(), "1 to 2: 5.00 mm");
  measure.add({3, 4, 2});
  EXPECT_NEAR(measure.angle(1), 90, 1e-9);
  EXPECT_NEAR(measure.length(), 7, 1e-12);
  EXPECT_EQ(measure.text(), "1 to 2: 5.00 mm; angle at 2: 90.0 degrees; 2 to 3: 2.00 mm; together 7.00 mm");
}

TEST(AppCommands, APixelIsWhereItsRayIs) {
  const auto camera = cameraFromView("30,40");
  const Ray ray = rayUnder(*camera, 123, 45, 800, 600);
  const auto pixel = pixelOf(*camera, ray.at(77), 800, 600);
  EXPECT_NEAR(pixel[0], 123, 1e-9);
  EXPECT_NEAR(pixel[1], 45, 1e-9);
}

TEST_F(WorkbenchTest, PointsAreMeasuredOnTheSurface) {
  const fs::path file = folder_.path() / "block.ply";
  ASSERT_TRUE(writeMesh(file, test::blockMesh(true)));
  Workbench bench(options());
  Camera camera = *cameraFromView("top");
  std::string copied;
  AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
  context.set_clipboard = [&](const std::string& text) { copied = text; };
  const auto played =
      runScript(context,
                folder_.write("s.ks", "file.open \"" + file.string() +
                                          "\"\nwait\nview.fit\nmeasure.point 150 150\nmeasure.point 250 150\n"
                                          "measure.copy\n"),
                [&] { bench.update(); });
  ASSERT_TRUE(played) << played.error().message();
  EXPECT_NEAR(bench.views->measure.distance(0), 100 * camera.mmPerPixel(300), 0.01);
  EXPECT_NE(copied.find("1 to 2"), std::string::npos) << copied;
  EXPECT_FALSE(runAppCommand(context, "measure.point", std::vector<std::string>{"2", "2"}));
  ASSERT_TRUE(runAppCommand(context, "measure.clear"));
  EXPECT_TRUE(bench.views->measure.points().empty());
}

}  // namespace
}  // namespace kerf::workbench_test
