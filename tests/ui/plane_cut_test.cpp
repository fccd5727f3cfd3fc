// Cutting at once by a plane: exact in the file, undone, replayed, continued.
#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/boolean/plane_cut.h"
#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/mesh_check.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/report/replay.h"
#include "tests/ui/block_on_bench.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"

namespace kerf::plane_cut_window_test {
namespace {

namespace fs = std::filesystem;

class CutAtOnce : public test::OnABlock {
 protected:
  std::string allNotices() const {
    std::string out;
    for (const Notice& notice : bench_.notices->list()) out += notice.text + "\n";
    return out;
  }
  std::size_t pieces() const { return bench_.document->report().object_count; }
  Expected<void> command(const char* id, std::vector<std::string> words = {}) {
    return runAppCommand(context_, id, words);
  }
  Expected<void> cut(const std::string& side) {
    KERF_CHECK(command("plane.cut", {side}));
    const std::uint64_t sent = bench_.document->sent();
    until([&] { return bench_.document->answered() >= sent; });
    bench_.update();
    return {};
  }
  fs::path end() {
    const fs::path run = bench_.document->sessionFolder();
    bench_.sessions->close();
    until([&] { return !bench_.jobs->running(); });
    return run;
  }
};

TEST_F(CutAtOnce, ExportsTheMeshOfKerfTrimToTheBit) {
  ASSERT_TRUE(command("saw.plane", {"0.13", "0", "-0.2", "1", "0.1", "0.05"}));
  const SawPlane plane = *bench_.saw->plan().chosen();
  const auto solid = readCaseSolid(bench_.document->run()->caseFolder());
  ASSERT_TRUE(solid);
  const std::array planes{Plane{plane.point, plane.normal}};
  const auto wanted = cutByPlanes(*solid, planes);
  ASSERT_TRUE(wanted) << wanted.error().message();

  ASSERT_TRUE(cut("above"));
  EXPECT_EQ(pieces(), 1u);
  const fs::path run = end();
  const auto exported = exportBundle(run);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->post_op.mesh.vertices, wanted->above.mesh.vertices);
  EXPECT_EQ(exported->post_op.mesh.triangles, wanted->above.mesh.triangles);
  EXPECT_TRUE(checkMesh(exported->post_op.mesh).print_ready);
  const auto replayed = replayRun(run);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
}

TEST_F(CutAtOnce, ThePlanIsHiddenAsLongAsItsCutIsDone) {
  ASSERT_TRUE(command("saw.plane", {"0.13", "0", "-0.2", "1", "0.1", "0.05"}));
  EXPECT_FALSE(bench_.saw->isPlanSpent());
  ASSERT_TRUE(cut("above"));
  until([&] { return bench_.saw->isPlanSpent(); });
  ASSERT_TRUE(command("edit.undo"));
  until([&] { return !bench_.saw->isPlanSpent(); });
  ASSERT_TRUE(command("edit.redo"));
  until([&] { return bench_.saw->isPlanSpent(); });
  ASSERT_TRUE(command("saw.move", {"0.1"}));
  EXPECT_FALSE(bench_.saw->isPlanSpent());
}

TEST_F(CutAtOnce, BothPartsAreExportedAndAContinuedSessionHasBoth) {
  ASSERT_TRUE(command("saw.plane", {"0.13", "0", "-0.2", "1", "0", "0"}));
  const SawPlane plane = *bench_.saw->plan().chosen();
  const fs::path case_folder = bench_.document->run()->caseFolder();
  ASSERT_TRUE(cut("both"));
  ASSERT_EQ(pieces(), 2u);
  ASSERT_TRUE(command("edit.undo"));
  until([&] { return pieces() == 1; });
  ASSERT_TRUE(command("edit.redo"));
  until([&] { return pieces() == 2; });

  const fs::path run = end();
  const auto exported = exportBundle(run);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->pieces.size(), 2u);
  const auto solid = readCaseSolid(case_folder);
  const std::array planes{Plane{plane.point, plane.normal}};
  const auto wanted = cutByPlanes(*solid, planes);
  ASSERT_TRUE(wanted);
  Mesh both = wanted->above.mesh;
  append(both, wanted->rest.mesh);
  EXPECT_EQ(exported->post_op.mesh.vertices, both.vertices);
  EXPECT_EQ(exported->post_op.mesh.triangles, both.triangles);

  bench_.sessions->open(run);
  until([&] { return !bench_.jobs->running() && bench_.document->scene().triangleCount() > 0; });
  ASSERT_TRUE(bench_.document->isOpen());
  until([&] { return pieces() == 2; });
}

TEST_F(CutAtOnce, DeletedPiecesAreNotExportedAndComeBackByOneUndo) {
  const auto do_and_wait = [&](const char* id, std::vector<std::string> words, std::size_t count) {
    const auto done = command(id, std::move(words));
    ASSERT_TRUE(done) << done.error().message();
    until([&] { return pieces() == count && bench_.document->scene().pieceCount() == count; });
    bench_.update();
  };
  ASSERT_TRUE(command("saw.plane", {"0.13", "0", "-0.2", "1", "0.1", "0.05"}));
  const SawPlane plane = *bench_.saw->plan().chosen();
  const auto solid = readCaseSolid(bench_.document->run()->caseFolder());
  ASSERT_TRUE(solid);
  do_and_wait("plane.cut", {"both"}, 2);
  ASSERT_TRUE(command("saw.move", {"-0.4"}));
  ASSERT_TRUE(command("piece.choose", {"2"}));
  do_and_wait("plane.cut", {"both"}, 3);

  // Two of them in one file.
  const fs::path two = folder_.path() / "two.stl";
  ASSERT_TRUE(command("piece.choose", {"1"}));
  ASSERT_TRUE(command("piece.add", {"3"}));
  ASSERT_TRUE(command("file.export-piece", {two.string()}));
  until([&] { return !bench_.jobs->running(); });
  const auto written = readMesh(two);
  ASSERT_TRUE(written) << allNotices();
  EXPECT_TRUE(checkMesh(written->mesh).print_ready);
  EXPECT_EQ(checkMesh(written->mesh).pieces, 2u);

  // By the list: the first, then all up to the third.
  const auto shown = bench_.document->scene().shown();
  ScenePieces& list = *bench_.pieces;
  list.choose(shown[0]->id);
  list.chooseTo(shown[2]->id);
  EXPECT_EQ(list.selected().size(), 3u);
  EXPECT_EQ(list.chosen(), shown[0]);
  const auto refused = command("piece.delete");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("a piece that stays"), std::string::npos) << refused.error().message();
  EXPECT_NE(refused.error().hint.find("hide"), std::string::npos);
  list.toggle(shown[0]->id);
  EXPECT_EQ(list.selected().size(), 2u);
  do_and_wait("piece.delete", {}, 1);
  EXPECT_NE(allNotices().find("2 pieces deleted, "), std::string::npos) << allNotices();
  EXPECT_EQ(bench_.steps->timeline().steps().back().kind, TimelineStep::Kind::kDelete);
  EXPECT_FALSE(command("piece.delete")) << "none is chosen any more";
  do_and_wait("edit.undo", {}, 3);
  EXPECT_EQ(list.selected().size(), 2u) << "they are chosen again";
  do_and_wait("edit.redo", {}, 1);

  const std::array planes{Plane{plane.point, plane.normal}};
  const auto wanted = cutByPlanes(*solid, planes);
  ASSERT_TRUE(wanted) << wanted.error().message();
  const fs::path run = end();
  const auto exported = exportBundle(run);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->post_op.mesh.vertices, wanted->above.mesh.vertices);
  EXPECT_EQ(exported->post_op.mesh.triangles, wanted->above.mesh.triangles);
  const auto replayed = replayRun(run);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;

  bench_.sessions->open(run);
  until([&] { return !bench_.jobs->running() && bench_.document->scene().triangleCount() > 0; });
  ASSERT_TRUE(bench_.document->isOpen());
  EXPECT_EQ(pieces(), 1u);
}

TEST_F(CutAtOnce, HalvesThatTouchGetAFileEachUnlessOneFileIsChosen) {
  ASSERT_TRUE(command("saw.plane", {"0.13", "0", "-0.2", "1", "0", "0"}));
  ASSERT_TRUE(cut("both"));
  until([&] { return bench_.document->scene().pieceCount() == 2; });
  ExportPlan& plan = *bench_.exporting;
  plan.show(folder_.path());
  until([&] { return plan.stage() == ExportPlan::Stage::kReady; });
  EXPECT_TRUE(plan.choice().is_each);
  plan.write();
  until([&] { return plan.stage() == ExportPlan::Stage::kWritten; });
  ASSERT_EQ(plan.written()->files.size(), 2u);
  EXPECT_TRUE(plan.written()->is_ready);

  plan.choose({});
  until([&] { return plan.stage() == ExportPlan::Stage::kDoubtful; });
  const std::vector<ExportFinding> findings = plan.findings();
  EXPECT_TRUE(std::any_of(findings.begin(), findings.end(), [](const ExportFinding& finding) {
    return finding.text.find("touch along a cut without kerf") != std::string::npos;
  }));
}

TEST_F(CutAtOnce, WithAKerfBothPartsFitOneFile) {
  ASSERT_TRUE(command("saw.plane", {"0.13", "0", "-0.2", "1", "0", "0"}));
  ASSERT_TRUE(command("plane.cut", {"both", "0.1"}));
  until([&] { return bench_.document->scene().pieceCount() == 2; });
  ExportPlan& plan = *bench_.exporting;
  plan.show(folder_.path());
  until([&] { return plan.stage() == ExportPlan::Stage::kReady; });
  EXPECT_FALSE(plan.choice().is_each);
}

TEST_F(CutAtOnce, APlaneThatMissesIsReported) {
  ASSERT_TRUE(command("saw.plane", {"0.13", "0", "-0.2", "1", "0", "0"}));
  ASSERT_TRUE(command("saw.move", {"50"}));
  const auto missed = command("plane.cut", {"both"});
  ASSERT_FALSE(missed);
  EXPECT_EQ(missed.error().code, Error::Code::kEmpty);
  EXPECT_FALSE(command("plane.cut", {"left"}));
}

}  // namespace
}  // namespace kerf::plane_cut_window_test
