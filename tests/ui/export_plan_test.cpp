#include "ui/app/workbench/export_plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "geometry/base/hash.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/quit_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/sessions.h"

namespace kerf::export_plan_test {
namespace {

namespace fs = std::filesystem;
using Stage = ExportPlan::Stage;

// A workbench with a bar on it, and a person who gives commands.
class ExportPlanTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(scan().parent_path());
    ASSERT_TRUE(writeMesh(scan(), test::blockMesh(true, {6, 1.6, 1.2})));
  }
  void TearDown() override {
    bench_.jobs->cancel();
    (void)play("wait\n");
    bench_.sessions->close();
    while (bench_.jobs->running()) bench_.update();
  }

  fs::path scan() const { return folder_.path() / "scans" / "bar.ply"; }
  fs::path besideScan(const std::string& name) const { return scan().parent_path() / name; }
  Expected<void> play(const std::string& script) {
    return runScript(context_, folder_.write("script.ks", script), [&] { bench_.update(); });
  }
  // Drills a hole a little to the right of the middle.
  std::string open() const { return "file.open \"" + scan().string() + "\"\nwait\nview.fit\n"; }
  static std::string drill(int x) {
    return fmt::format(
        "tool.select round-010\ncut.force 2\ncut.depth 0.3\ncut.press {} 150\nwait 1.5\ncut.release\nwait 0.2\n", x);
  }
  static std::string sawThrough() {
    return "tool.select disc-22\ncut.force 3\ncut.depth 2.2\ncut.press 200 150\nwait 5\ncut.release\nwait 1\n"
           "expect pieces 2 2\n";
  }
  std::string allFindings() const {
    std::string out;
    for (const ExportFinding& finding : plan_.findings()) out += finding.text + "\n";
    return out;
  }
  std::string allNotices() const {
    std::string out;
    for (const Notice& notice : bench_.notices->list()) out += notice.text + "\n";
    return out;
  }
  static double volumeOf(const fs::path& file) {
    const auto mesh = readMesh(file);
    EXPECT_TRUE(mesh) << mesh.error().message();
    return mesh ? signedVolume(mesh->mesh) : 0;
  }

  TemporaryFolder folder_;
  WorkbenchOptions options() const {
    WorkbenchOptions out;
    out.data_folder = folder_.path() / "data";
    out.tools = {"disc-22", "round-010"};
    out.real_time = {.priority = 0, .lock_memory = false};
    return out;
  }
  Workbench bench_{options()};
  Camera camera_ = *cameraFromView("top");
  AppContext context_{.bench = bench_, .camera = camera_, .width = 400, .height = 300};
  ExportPlan& plan_ = *bench_.exporting;
};

TEST_F(ExportPlanTest, WhatKerfCheckWillSayIsKnownBeforeAnythingIsWritten) {
  const auto shown = play(open() + drill(230) + "export.show\nwait\nexpect verdict 1 1\n");
  ASSERT_TRUE(shown) << shown.error().message() << allNotices();
  EXPECT_EQ(plan_.file(), besideScan("bar-cut.stl"));
  EXPECT_FALSE(fs::exists(plan_.file()));
  EXPECT_EQ(plan_.stage(), Stage::kReady);
  const std::string before = allFindings();
  EXPECT_NE(before.find("Ready to print."), std::string::npos) << before;

  ASSERT_TRUE(play("export.write\nwait\n")) << allNotices();
  const auto mesh = readMesh(besideScan("bar-cut.stl"));
  ASSERT_TRUE(mesh) << mesh.error().message();
  EXPECT_NE(before.find(describe(checkMesh(mesh->mesh))), std::string::npos) << before << "\nas kerf check says:\n"
                                                                             << describe(checkMesh(mesh->mesh));
  EXPECT_TRUE(plan_.isDone());
  ASSERT_TRUE(plan_.written());
  EXPECT_TRUE(plan_.written()->is_ready);
  EXPECT_NE(plan_.written()->text.find("ready to print"), std::string::npos) << plan_.written()->text;
}

TEST_F(ExportPlanTest, WhatIsCutAfterTheCheckIsCheckedAndWrittenToo) {
  ASSERT_TRUE(play(open() + drill(230) + "export.show\nwait\n")) << allNotices();
  EXPECT_FALSE(plan_.isOutdated());
  ASSERT_TRUE(play("export.write\nwait\n")) << allNotices();
  const double once = volumeOf(besideScan("bar-cut.stl"));
  EXPECT_FALSE(bench_.results->hasUnexportedCut());

  ASSERT_TRUE(play(drill(150)));
  EXPECT_TRUE(plan_.isOutdated());
  EXPECT_FALSE(plan_.isDone());
  EXPECT_TRUE(bench_.results->hasUnexportedCut());
  ASSERT_TRUE(play("export.write replace\nwait\n")) << allNotices();
  EXPECT_LT(volumeOf(besideScan("bar-cut.stl")), once - 0.02);
  EXPECT_TRUE(plan_.isDone());
}

TEST_F(ExportPlanTest, EachFormatOfTheTableIsWrittenUnderItsEnding) {
  ASSERT_TRUE(play(open() + drill(230) + "export.show\n"));
  for (const MeshFormatRow* format : ExportPlan::formats()) {
    const auto written = play(fmt::format("export.format {}\nexport.write\nwait\n", format->name));
    ASSERT_TRUE(written) << written.error().message();
    EXPECT_EQ(plan_.format(), format);
    ASSERT_TRUE(plan_.written()) << format->name;
    EXPECT_TRUE(format->extensions.starts_with(plan_.file().extension().string())) << plan_.file();
    EXPECT_TRUE(checkMesh(readMesh(plan_.file())->mesh).print_ready) << plan_.file();
  }
  EXPECT_GE(ExportPlan::formats().size(), 5u);

  const auto wrong = play("export.format step\n");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message().find("stl, ply"), std::string::npos) << wrong.error().message();
  EXPECT_FALSE(play("export.to cut.xyz\n"));
  ASSERT_TRUE(play("export.format ply\nexport.to \"" + (folder_.path() / "named").string() + "\"\n"));
  EXPECT_EQ(plan_.file(), folder_.path() / "named.ply") << "a name without an ending keeps the format";
}

TEST_F(ExportPlanTest, NothingIsReplacedAtTheFirstWord) {
  ASSERT_TRUE(play(open() + drill(230)));
  std::ofstream(besideScan("bar-cut.stl")) << "mine";
  ASSERT_TRUE(play("export.show\nwait\n"));
  EXPECT_EQ(plan_.replaced(), std::vector<fs::path>{besideScan("bar-cut.stl")});
  const auto refused = play("export.write\nwait\n");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("an existing file"), std::string::npos) << refused.error().message();
  EXPECT_EQ(fs::file_size(besideScan("bar-cut.stl")), 4u);
  EXPECT_TRUE(plan_.asksToReplace()) << "a button, or Enter, asked for once more";
  const fs::path typed_over = plan_.file();
  for (const char* const typed : {"jaw", "jaw.off", "jaw.offset"}) plan_.setName(typed, typed_over);
  EXPECT_EQ(plan_.file(), typed_over.parent_path() / "jaw.offset.stl") << "the ending stays through all that is typed";
  plan_.setName("/elsewhere/jaw", typed_over);
  EXPECT_EQ(plan_.file(), "/elsewhere/jaw.stl") << "a whole path is taken";
  plan_.setName("bar-cut.stl", typed_over);
  EXPECT_FALSE(plan_.asksToReplace()) << "another name is another question";
  plan_.write();
  EXPECT_TRUE(plan_.asksToReplace());
  plan_.write();
  ASSERT_TRUE(play("wait\n")) << allNotices();
  EXPECT_GT(fs::file_size(besideScan("bar-cut.stl")), 4u);

  // The scan itself is never replaced.
  const auto before = sha256OfFile(scan());
  EXPECT_FALSE(play("export.to \"" + scan().string() + "\"\nexport.write replace\nwait\n"));
  EXPECT_EQ(*sha256OfFile(scan()), *before);
}

TEST_F(ExportPlanTest, PiecesAreOfferedEachAndAlone) {
  ASSERT_TRUE(play(open() + sawThrough() + "piece.choose 2\npiece.rename left\n")) << allNotices();
  ASSERT_TRUE(play("export.show\nwait\nexport.pieces each\nwait\nexpect verdict 1 1\n")) << allNotices();
  EXPECT_NE(allFindings().find("left:\nReady to print."), std::string::npos) << allFindings();
  ASSERT_TRUE(play("export.write\nwait\n")) << allNotices();
  ASSERT_TRUE(plan_.written());
  EXPECT_EQ(plan_.written()->files,
            (std::vector<fs::path>{besideScan("bar-cut-piece-1.stl"), besideScan("bar-cut-left.stl")}));

  ASSERT_TRUE(play("export.pieces piece left\nexport.write\nwait\n")) << allNotices();
  EXPECT_EQ(plan_.file(), besideScan("bar-left.stl"));
  EXPECT_NEAR(volumeOf(plan_.file()), volumeOf(besideScan("bar-cut-left.stl")), 1e-9);

  ASSERT_TRUE(play("export.pieces all\nwait\nexpect verdict 1 1\nexport.write\nwait\n")) << allNotices();
  EXPECT_EQ(checkMesh(readMesh(besideScan("bar-cut.stl"))->mesh).pieces, 2u);
  const auto wrong = play("export.pieces piece right\n");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message().find("Only left"), std::string::npos) << wrong.error().message();
  EXPECT_FALSE(play("export.pieces put-back\n")) << "nothing was moved";
}

// Severed by a bur: the file is that of the other piece alone.
TEST_F(ExportPlanTest, ADeletedPieceIsNotInTheFile) {
  const fs::path one = folder_.path() / "one.stl", left = folder_.path() / "left.stl";
  ASSERT_TRUE(play(open() + sawThrough() + "export.show\nwait\nexport.pieces piece 1\nexport.to \"" + one.string() +
                   "\"\nexport.write\nwait\npiece.delete 2\nwait 0.2\nexpect pieces 1 1\n"))
      << allNotices();
  EXPECT_NE(allNotices().find("1 piece deleted, "), std::string::npos) << allNotices();
  ASSERT_TRUE(
      play("export.pieces all\nwait\nexpect verdict 1 1\nexport.to \"" + left.string() + "\"\nexport.write\nwait\n"))
      << allNotices();
  const auto before = readMesh(one), after = readMesh(left);
  ASSERT_TRUE(before && after);
  EXPECT_EQ(checkMesh(after->mesh).pieces, 1u);
  const Box3 box = bounds(before->mesh), box_after = bounds(after->mesh);
  EXPECT_LT((box.min - box_after.min).norm() + (box.max - box_after.max).norm(), 0.05) << "mm";
  EXPECT_NEAR(signedVolume(before->mesh), signedVolume(after->mesh), 1e-4) << "the cut face, from another solid";
}

TEST_F(ExportPlanTest, OnePieceOfSeveralIsNotTheCut) {
  ASSERT_TRUE(play(open() + sawThrough() + "export.show\nwait\n")) << allNotices();
  const fs::path one = folder_.path() / "one.stl";
  ASSERT_TRUE(play("export.pieces piece 2\nexport.to \"" + one.string() + "\"\nexport.write\nwait\n")) << allNotices();
  ASSERT_TRUE(plan_.written());
  ASSERT_TRUE(fs::exists(one));
  EXPECT_TRUE(bench_.results->hasUnexportedCut()) << "the other piece is nowhere yet";
  bench_.results->exportTo(folder_.path() / "again.stl", {.only = {bench_.document->scene().shown().front()->id}});
  ASSERT_TRUE(play("wait\n")) << allNotices();
  EXPECT_TRUE(bench_.results->hasUnexportedCut());
  ASSERT_TRUE(play("export.pieces each\nexport.write\nwait\n")) << allNotices();
  EXPECT_FALSE(bench_.results->hasUnexportedCut());
}

// A choice made during a write does not undo the write.
TEST_F(ExportPlanTest, AFileThatIsWrittenIsToldWhateverWasChosenMeanwhile) {
  ASSERT_TRUE(play(open() + sawThrough() + "export.show\nwait\n")) << allNotices();
  plan_.write();
  ASSERT_TRUE(bench_.jobs->running());
  plan_.choose({.is_each = true});
  ASSERT_TRUE(play("wait\n")) << allNotices();
  EXPECT_TRUE(fs::exists(besideScan("bar-cut.stl")));
  EXPECT_NE(allNotices().find("bar-cut.stl: "), std::string::npos) << allNotices();
  EXPECT_FALSE(bench_.results->hasUnexportedCut());
  EXPECT_FALSE(plan_.written()) << "of what is chosen now nothing is written";
  EXPECT_EQ(plan_.stage(), Stage::kReady) << "it is checked";

  // The same for a changed name.
  plan_.write();
  ASSERT_TRUE(bench_.jobs->running());
  plan_.setName("other.stl", plan_.file());
  ASSERT_TRUE(play("wait\n")) << allNotices();
  EXPECT_TRUE(fs::exists(besideScan("bar-cut-piece-1.stl")));
  EXPECT_NE(allNotices().find("bar-cut-piece-1.stl"), std::string::npos) << allNotices();
  EXPECT_FALSE(plan_.isDone()) << "other.stl is not written";
}

// The choice changes during its check, and Enter follows at once: the file is written as soon as the new choice is
// checked.
TEST_F(ExportPlanTest, WhatIsAskedForWhileAnOldCheckEndsIsWrittenAfterTheNextOne) {
  ASSERT_TRUE(play(open() + sawThrough())) << allNotices();
  plan_.show({});
  while (!plan_.isBusy()) bench_.update();
  plan_.choose({.is_each = true});
  ASSERT_TRUE(bench_.jobs->running()) << "the check of the other choice is not over";
  plan_.write();
  ASSERT_TRUE(play("wait\n")) << allNotices();
  EXPECT_EQ(plan_.stage(), Stage::kWritten) << allNotices();
  EXPECT_TRUE(fs::exists(besideScan("bar-cut-piece-1.stl")));
  EXPECT_FALSE(fs::exists(besideScan("bar-cut.stl")));
}

// Checked with two pieces, then there are three: the user has not seen the name of the third file.
TEST_F(ExportPlanTest, AFileThatWasNotNamedIsNotReplaced) {
  const auto names = [&] {
    std::vector<std::string> out;
    for (const SceneObject* piece : bench_.document->scene().shown()) out.push_back(piece->name);
    return out;
  };
  ASSERT_TRUE(play(open() + sawThrough() + "export.show\nwait\nexport.pieces each\nwait\n")) << allNotices();
  const std::vector<std::string> before = names();
  ASSERT_TRUE(play("cut.press 140 150\nwait 5\ncut.release\nwait 1\nexpect pieces 3 3\n")) << allNotices();
  std::string fresh;
  for (const std::string& name : names())
    if (std::find(before.begin(), before.end(), name) == before.end()) fresh = name;
  ASSERT_FALSE(fresh.empty());
  std::replace(fresh.begin(), fresh.end(), ' ', '-');
  const fs::path third = besideScan("bar-cut-" + fresh + ".stl");
  std::ofstream(third) << "mine";

  const auto refused = play("export.write\nwait\n");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find(third.string()), std::string::npos) << refused.error().message();
  EXPECT_EQ(fs::file_size(third), 4u);
  EXPECT_FALSE(fs::exists(besideScan("bar-cut-piece-1.stl"))) << "all or none";
  EXPECT_EQ(plan_.replaced(), std::vector<fs::path>{third});
  EXPECT_TRUE(plan_.asksToReplace());

  plan_.write();
  do bench_.update();
  while (bench_.jobs->running());
  EXPECT_TRUE(plan_.written()) << allNotices();
  EXPECT_GT(fs::file_size(third), 4u) << "asked for a second time";
}

// Overlapping pieces are not ready. A user who has read this may export them.
TEST_F(ExportPlanTest, WhatIsNotReadyIsNotWrittenBeforeSomebodyHasReadSo) {
  ASSERT_TRUE(play(open() + sawThrough() + "piece.move 1.5 0.2 0.1 2\nwait 0.2\n")) << allNotices();
  const auto blind = play("export.show\nexport.write\nwait\n");
  ASSERT_FALSE(blind);
  EXPECT_NE(blind.error().message().find("not ready to print"), std::string::npos) << blind.error().message();
  EXPECT_FALSE(fs::exists(besideScan("bar-cut.stl")));
  EXPECT_EQ(plan_.stage(), Stage::kDoubtful);
  EXPECT_NE(allFindings().find("the moved pieces overlap"), std::string::npos) << allFindings();

  // A script would end at that error; a person continues.
  const auto finish = [&] {
    do bench_.update();
    while (bench_.jobs->running());
  };
  plan_.write();
  finish();
  ASSERT_TRUE(plan_.written()) << allNotices();
  EXPECT_FALSE(plan_.written()->is_ready);
  EXPECT_TRUE(fs::exists(besideScan("bar-cut.stl")));

  plan_.choose({.is_put_back = true});
  finish();
  EXPECT_EQ(plan_.stage(), Stage::kReady) << allFindings();
}

TEST_F(ExportPlanTest, TheWindowIsNotKeptAndACheckPutAwayLeavesNothing) {
  ASSERT_TRUE(play(open() + drill(230)));
  plan_.show({});
  bench_.update();
  ASSERT_TRUE(bench_.jobs->running());
  EXPECT_FALSE(bench_.jobs->isWriting()) << "nobody waits for it at the end";
  plan_.hide();
  ASSERT_TRUE(play("wait\n")) << allNotices();
  EXPECT_FALSE(plan_.isShown());
  EXPECT_TRUE(plan_.findings().empty());
  EXPECT_FALSE(fs::exists(besideScan("bar-cut.stl")));
  EXPECT_EQ(allNotices().find("cancelled"), std::string::npos) << allNotices();
}

TEST_F(ExportPlanTest, ItIsWrittenWhereAUserLooksForIt) {
  // Beside the scan; if that folder is not writable, in the last export folder.
  fs::create_directories(folder_.path() / "last");
  fs::permissions(scan().parent_path(), fs::perms::owner_read | fs::perms::owner_exec);
  ASSERT_TRUE(play(open()));
  plan_.show(folder_.path() / "last");
  const bool is_root = ::access(scan().parent_path().c_str(), W_OK) == 0;
  EXPECT_EQ(plan_.file().parent_path(), is_root ? scan().parent_path() : folder_.path() / "last");
  fs::permissions(scan().parent_path(), fs::perms::owner_all);
  plan_.hide();
  plan_.show({});
  EXPECT_EQ(plan_.file(), besideScan("bar-cut.stl"));
  plan_.hide();

  // For files in the program's own folders: never there.
  const fs::path kept = fs::directory_iterator(folder_.path() / "data" / "cases")->path();
  ASSERT_TRUE(play("wait\nfile.close\nwait\nfile.open \"" + kept.string() + "\"\nwait\n")) << allNotices();
  plan_.show(folder_.path() / "last");
  EXPECT_EQ(plan_.file().parent_path(), folder_.path() / "last");
  EXPECT_TRUE(plan_.file().filename().string().ends_with("-cut.stl")) << plan_.file();
}

// ---- Quitting

TEST_F(ExportPlanTest, QuittingAsksOnceAboutACutThatWasNotExported) {
  context_.asks_before_quit = true;
  ASSERT_TRUE(play(open() + drill(230)));
  ASSERT_TRUE(play("app.quit\n"));
  EXPECT_FALSE(context_.wants_quit);
  EXPECT_TRUE(context_.is_asking_to_quit);
  const std::string asked = quit::question(bench_);
  EXPECT_EQ(asked.find("Your cut is saved in " + bench_.document->sessionFolder().string() + ", but not exported."), 0u)
      << asked;

  ASSERT_TRUE(play("app.stay\n"));
  EXPECT_FALSE(context_.is_asking_to_quit);
  ASSERT_TRUE(play("app.quit\n"));
  quit::exportFirst(context_);
  EXPECT_FALSE(context_.is_asking_to_quit);
  EXPECT_TRUE(plan_.isShown());
  ASSERT_TRUE(play("wait\napp.quit\n"));
  EXPECT_TRUE(context_.is_asking_to_quit) << "checked is not exported";
  ASSERT_TRUE(play("app.quit\n"));
  EXPECT_TRUE(context_.wants_quit) << "asked once: the second time is the answer";
}

TEST_F(ExportPlanTest, NobodyIsAskedAboutWhatIsExportedOrUncutOrInAScript) {
  context_.asks_before_quit = true;
  const auto quits = [&] {
    EXPECT_TRUE(play("app.quit\n"));
    EXPECT_EQ(context_.wants_quit, !context_.is_asking_to_quit);
    context_.is_asking_to_quit = false;
    return std::exchange(context_.wants_quit, false);
  };
  EXPECT_TRUE(quits()) << "nothing is open";
  ASSERT_TRUE(play(open()));
  EXPECT_TRUE(quits()) << "nothing is cut";
  ASSERT_TRUE(play(drill(230)));
  EXPECT_FALSE(quits());
  ASSERT_TRUE(play("edit.undo\nwait 0.3\n"));
  EXPECT_TRUE(quits()) << "it was taken back";
  ASSERT_TRUE(play("edit.redo\nwait 0.3\n"));
  EXPECT_FALSE(quits());

  ASSERT_TRUE(play("file.export \"" + (folder_.path() / "a.stl").string() + "\"\nwait\n")) << allNotices();
  EXPECT_TRUE(quits()) << "it is exported";
  ASSERT_TRUE(play("view.fit\ntool.select disc-22\nwait 0.2\n"));
  EXPECT_TRUE(quits()) << "another tool is no cut";
  ASSERT_TRUE(play(drill(150)));
  EXPECT_FALSE(quits()) << "a stroke since";
  context_.asks_before_quit = false;
  EXPECT_TRUE(quits()) << "in a script there is nobody";
}

}  // namespace
}  // namespace kerf::export_plan_test
