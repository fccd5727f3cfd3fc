// Cutting at once by a plane: exact in the file, undone, replayed, continued.
#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/boolean/plane_cut.h"
#include "geometry/case/case_bundle.h"
#include "geometry/mesh/mesh_check.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/report/replay.h"
#include "tests/ui/block_on_bench.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"

namespace kerf::plane_cut_window_test {
namespace {

namespace fs = std::filesystem;

class CutAtOnce : public test::OnABlock {
 protected:
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
