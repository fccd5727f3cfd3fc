#include "ui/app/import/import_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <thread>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_writer.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/imports.h"

namespace kerf::import_plan_test {
namespace {

namespace fs = std::filesystem;

class ImportPlanTest : public testing::Test {
 protected:
  // A block of 6 x 4 x 3 mm, without its underside like a scan, or whole.
  fs::path block(bool is_closed = false, double scale = 1) const {
    Mesh mesh = test::blockMesh(is_closed);
    for (Vec3d& p : mesh.vertices) p *= scale;
    const fs::path file = folder_.path() / "block.ply";
    EXPECT_TRUE(writeMesh(file, mesh));
    return file;
  }
  // Its rim has more edges than a face of a block.
  fs::path bowl() const {
    Mesh mesh = ballMesh({0, 0, 0}, 3, 60);
    std::erase_if(mesh.triangles, [&](const Triangle& f) { return mesh.vertices[f[0]].z() < 0; });
    const fs::path file = folder_.path() / "bowl.ply";
    EXPECT_TRUE(writeMesh(file, mesh));
    return file;
  }
  ImportPlan planOf(const fs::path& file) const {
    auto found = readScan(file);
    EXPECT_TRUE(found) << found.error().message();
    return ImportPlan(std::move(*found), {});
  }
  static void work(ImportPlan& plan) {
    for (int n = 0; n < 1000 && !plan.preview() && !plan.previewError(); ++n) {
      plan.update();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  static std::string textOf(const ImportPlan& plan) {
    std::string out;
    for (const Finding& finding : plan.findings()) out += finding.about + ": " + finding.text + "\n";
    return out;
  }
  TemporaryFolder folder_;
};

TEST_F(ImportPlanTest, SaysWhatWasFoundInATechniciansWords) {
  const ImportPlan open = planOf(block());
  EXPECT_TRUE(open.isWithoutUnderside());
  EXPECT_NEAR(open.rimMm(), 20, 1e-5);
  EXPECT_NE(textOf(open).find("6.0 x 4.0 x 3.0 mm"), std::string::npos) << textOf(open);
  EXPECT_NE(textOf(open).find("the underside is missing"), std::string::npos) << textOf(open);
  EXPECT_NE(textOf(open).find("a rim of 20 mm"), std::string::npos) << textOf(open);
  EXPECT_GT(open.found().up.z(), 0.5) << "an open block is looked at from above, not into its hollow";

  const ImportPlan closed = planOf(block(true));
  EXPECT_FALSE(closed.isWithoutUnderside());
  EXPECT_NE(textOf(closed).find("closed: a solid already"), std::string::npos) << textOf(closed);
}

TEST_F(ImportPlanTest, AUnitChangesTheSizeAndNothingIsScaledSilently) {
  ImportPlan plan = planOf(block(false, 0.1));  // 0.6 x 0.4 x 0.3 of an unknown unit: cm or inches
  const UnitOption cm = plan.units()[1];
  EXPECT_EQ(cm.unit, "cm");
  EXPECT_TRUE(cm.is_plausible);
  EXPECT_FALSE(plan.units()[0].is_plausible) << "0.8 mm across";

  EXPECT_EQ(plan.unit().unit, "mm") << "two units would fit: none is taken on a guess";
  EXPECT_NE(textOf(plan).find("not a dental size"), std::string::npos) << textOf(plan);
  ASSERT_TRUE(plan.setUnit("cm"));
  EXPECT_NEAR(plan.boxMm().size()[0], 6, 1e-5);
  EXPECT_EQ(plan.result().unit, "cm");
  EXPECT_NE(textOf(plan).find("as chosen. Scaled by 10"), std::string::npos) << textOf(plan);

  const auto refused = plan.setUnit("furlong");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("mm, cm, m, um or inch"), std::string::npos);
  EXPECT_EQ(plan.unit().unit, "cm");
}

TEST_F(ImportPlanTest, ThePreviewIsTheSolidThatTheChoicesGive) {
  ImportPlan plan = planOf(block());
  ClosingChoice straight = plan.closing();
  straight.smooth_mm = 0;  // a volume with a formula
  ASSERT_TRUE(plan.setClosing(straight));
  work(plan);
  ASSERT_TRUE(plan.preview()) << plan.previewError()->message();
  EXPECT_NEAR(plan.preview()->volume_mm3, 6 * 4 * (3 + 2), 1e-3);
  ASSERT_TRUE(plan.preview()->base_direction);
  EXPECT_TRUE(*plan.preview()->base_direction == -Vec3d::UnitZ());
  EXPECT_NEAR(plan.preview()->base_level_mm, 5, 1e-5);
  EXPECT_TRUE(plan.preview()->is_exact);

  // A new choice outdates it at once. The next result belongs to the new choice.
  ClosingChoice thick = plan.closing();
  thick.base_mm = 4;
  ASSERT_TRUE(plan.setClosing(thick));
  EXPECT_FALSE(plan.preview());
  work(plan);
  ASSERT_TRUE(plan.preview());
  EXPECT_NEAR(plan.preview()->volume_mm3, 6 * 4 * (3 + 4), 1e-3);

  // The voxel size does not affect the solid.
  ASSERT_TRUE(plan.setVoxel(0.2));
  EXPECT_TRUE(plan.preview());
}

TEST_F(ImportPlanTest, WhatCannotBeClosedIsSaidBeforeItIsPrepared) {
  ImportPlan plan = planOf(bowl());
  ClosingChoice holes = plan.closing();
  holes.way = ClosingChoice::Way::kHolesOnly;
  ASSERT_TRUE(plan.setClosing(holes));
  work(plan);
  EXPECT_FALSE(plan.preview());
  ASSERT_TRUE(plan.previewError());
  EXPECT_FALSE(plan.previewError()->message().empty());
}

TEST_F(ImportPlanTest, AWrapWaitsUntilItIsAskedFor) {
  ImportPlan plan = planOf(block());
  ClosingChoice wrap = plan.closing();
  wrap.way = ClosingChoice::Way::kWrap;
  ASSERT_TRUE(plan.setClosing(wrap));
  EXPECT_FALSE(plan.startsByItself());
  for (int n = 0; n < 100; ++n) {
    plan.update();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_FALSE(plan.previewJob());
  plan.startPreview();
  work(plan);
  ASSERT_TRUE(plan.preview()) << plan.previewError()->message();
  EXPECT_FALSE(plan.preview()->is_exact);
}

TEST_F(ImportPlanTest, ChoicesOutOfRangeChangeNothing) {
  ImportPlan plan = planOf(block());
  ClosingChoice bad = plan.closing();
  bad.base_mm = 0;
  EXPECT_FALSE(plan.setClosing(bad));
  bad = plan.closing();
  bad.wrap_mm = 100;
  EXPECT_FALSE(plan.setClosing(bad));
  bad = plan.closing();
  bad.holes_up_to_mm = -1;
  EXPECT_FALSE(plan.setClosing(bad));
  bad = plan.closing();
  bad.follows_occlusal_plane = true;
  EXPECT_FALSE(plan.setClosing(bad)) << "a block has no cusp tips";
  EXPECT_EQ(plan.closing(), ClosingChoice{});
  EXPECT_FALSE(plan.setVoxel(1e-9));
  EXPECT_FALSE(plan.setVoxel(std::nan("")));
  EXPECT_EQ(plan.voxel(), 0.1);
}

TEST(Predict, FourTimesTheVoxelsForHalfTheSize) {
  const Prediction coarse = predict(5000, 0.2, 1), fine = predict(5000, 0.1, 1);
  EXPECT_NEAR(fine.surface_triangles / coarse.surface_triangles, 4, 1e-9);
  EXPECT_GT(fine.seconds, coarse.seconds);
  EXPECT_GT(fine.bytes, coarse.bytes);
  // A scan of an upper arch, 5108 mm2 closed, at 0.1 mm took 3.6 s and 728 MB, with 0.6 s for closing.
  const Prediction arch = predict(5108, 0.1, 0.6);
  EXPECT_NEAR(arch.bytes / 728e6, 1, 0.15);
  EXPECT_NEAR(arch.surface_triangles / 1.367e6, 1, 0.15);
}

TEST_F(ImportPlanTest, ACutScanKeepsItsOtherPointsAndCanBeTakenBack) {
  ImportPlan plan = planOf(bowl());
  const Mesh& read = *plan.found().mesh;
  const Box3 before = plan.boxMm();
  const auto as_read = plan.mesh();
  ASSERT_TRUE(plan.trim(PlaneTrim{{0, 0, 1}, -Vec3d::UnitZ()}));
  ASSERT_TRUE(plan.trimmed());
  EXPECT_GT(plan.trimmed()->triangles_removed, 0u);
  EXPECT_EQ(plan.mesh()->triangles.size() + plan.trimmed()->triangles_removed, read.triangles.size());
  EXPECT_NEAR(surfaceArea(*plan.mesh()) + plan.trimmed()->removed_mm2, surfaceArea(read), 1e-9);
  EXPECT_LT(plan.boxMm().size().z(), before.size().z()) << "the box is that of the rest";
  EXPECT_GE(plan.boxMm().min.z(), 1);

  // A useless cut is an error, and changes nothing.
  const ClosingChoice kept = plan.closing();
  EXPECT_EQ(plan.trim(PlaneTrim{{0, 0, 1}, -Vec3d::UnitZ()}).error().code, Error::Code::kEmpty);
  EXPECT_EQ(plan.trim(PlaneTrim{{0, 0, -9}, Vec3d::UnitZ()}).error().code, Error::Code::kEmpty);
  EXPECT_EQ(plan.closing(), kept);

  // The preview closes the rest.
  work(plan);
  ASSERT_TRUE(plan.preview()) << plan.previewError()->message();
  EXPECT_NE(plan.preview()->changes[0].find("1 cut removed"), std::string::npos) << plan.preview()->changes[0];

  // The other side of a cut by the smaller part is the larger one.
  ASSERT_TRUE(plan.trim(plan.removingLess({{1, 0, 0}, -Vec3d::UnitX()})));
  EXPECT_LE(plan.boxMm().max.x(), 1);
  EXPECT_LT(plan.boxMm().min.x(), -2);
  ASSERT_TRUE(plan.flipTrim());
  EXPECT_GE(plan.boxMm().min.x(), 1);

  EXPECT_TRUE(plan.undoTrim());
  EXPECT_EQ(plan.closing(), kept);
  EXPECT_TRUE(plan.undoTrim());
  EXPECT_EQ(plan.mesh(), as_read) << "the scan as read";
  EXPECT_FALSE(plan.trimmed());
  EXPECT_FALSE(plan.undoTrim());
}

TEST_F(ImportPlanTest, AnotherUnitKeepsTheSameTriangles) {
  ImportPlan plan = planOf(bowl());
  ASSERT_TRUE(plan.trim(PlaneTrim{{0, 0, 1}, -Vec3d::UnitZ()}));
  const std::size_t removed = plan.trimmed()->triangles_removed;
  ASSERT_TRUE(plan.setUnit("cm"));
  const auto now = trimScan(*plan.found().mesh, plan.closing().trims, plan.unit().scale_to_mm);
  ASSERT_TRUE(now);
  EXPECT_EQ(now->triangles_removed, removed);
  EXPECT_NEAR(plan.trimmed()->removed_mm2, now->removed_mm2, 1e-9 * now->removed_mm2);
}

// ---- By commands, as in the window

class ImportCommandsTest : public ImportPlanTest {
 protected:
  Expected<void> play(Workbench& bench, const std::string& script) {
    Camera camera = *cameraFromView("top");
    AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
    return runScript(context, folder_.write("script.ks", script), [&] { bench.update(); });
  }
  WorkbenchOptions options() const {
    WorkbenchOptions out;
    out.data_folder = folder_.path() / "data";
    out.tools = {"round-014"};
    out.real_time = {.priority = 0, .lock_memory = false};
    return out;
  }
  std::size_t cases() const {
    std::error_code none;
    const fs::directory_iterator in(folder_.path() / "data" / "cases", none);
    return none ? 0 : static_cast<std::size_t>(std::distance(begin(in), end(in)));
  }
};

TEST_F(ImportCommandsTest, AScanIsReadLookedAtAndPreparedAsChosen) {
  Workbench bench(options());
  const std::string read = "import.read \"" + block().string() + "\"\nwait\n";
  ASSERT_TRUE(play(bench, read + "import.base full 4\nimport.voxel 0.2\nwait\n"));
  ASSERT_TRUE(bench.imports->plan());
  EXPECT_FALSE(bench.document->isOpen());
  EXPECT_EQ(cases(), 0u) << "nothing is prepared before the user says so";
  ASSERT_TRUE(bench.imports->plan()->preview()) << "a script waits for it";

  const auto played = play(bench, "import.start\nwait\n");
  ASSERT_TRUE(played) << played.error().message();
  EXPECT_FALSE(bench.imports->plan());
  ASSERT_TRUE(bench.document->isOpen());
  EXPECT_NEAR(bench.document->scene().bounds().size()[2], 3 + 4, 0.2) << "as drawn: within a voxel";
  EXPECT_NE(bench.notices->list().back().text.find("voxel size 0.2 mm"), std::string::npos)
      << bench.notices->list().back().text;
}

// From the top, at about 40 pixels a mm.
TEST_F(ImportCommandsTest, LassoAndLineCutPartsAwayAndTheCaseRepeatsThem) {
  Workbench bench(options());
  const std::string read = "import.read \"" + bowl().string() + "\"\nwait\nview.top\nview.fit\n";
  ASSERT_TRUE(play(bench, read + "import.trim-lasso 0 0 150 0 150 300 0 300\n"));
  const TrimmedScan* trimmed = bench.imports->plan()->trimmed();
  ASSERT_TRUE(trimmed);
  const std::size_t by_lasso = trimmed->triangles_removed;
  EXPECT_GT(by_lasso, 100u);
  const Box3 box = bench.imports->plan()->boxMm();
  EXPECT_NEAR(box.max.x(), 3, 0.1);
  EXPECT_GT(box.min.x(), -2.9) << "the left side went";

  const auto line = play(bench, "view.top\nview.fit\nimport.trim-line 250 0 250 300\nwait\n");
  ASSERT_TRUE(line) << line.error().message();
  EXPECT_GT(bench.imports->plan()->trimmed()->triangles_removed, by_lasso);
  EXPECT_LT(bench.imports->plan()->boxMm().max.x(), 2.9);
  ASSERT_TRUE(play(bench, "import.trim-undo\n"));
  EXPECT_EQ(bench.imports->plan()->trimmed()->triangles_removed, by_lasso);

  const auto played = play(bench, "import.trim-rim 1\nimport.voxel 0.2\nimport.start\nwait\n");
  ASSERT_TRUE(played) << played.error().message();
  const fs::path made = fs::directory_iterator(folder_.path() / "data" / "cases")->path();
  EXPECT_EQ(readCaseManifest(made)->closing.at("triangles_cut_away"), static_cast<double>(by_lasso));

  // Another import repeats them: the same case.
  ASSERT_TRUE(play(bench, read + "import.trim-load \"" + made.string() +
                              "\"\nimport.trim-rim 1\nimport.voxel 0.2\nimport.start\nwait\n"));
  EXPECT_EQ(cases(), 1u);
}

TEST_F(ImportCommandsTest, ALassoRemovesWhatLiesUnderItInPerspectiveToo) {
  Workbench bench(options());
  ASSERT_TRUE(play(bench, "import.read \"" + bowl().string() + "\"\nwait\n"));
  const ImportPlan& plan = *bench.imports->plan();
  for (const double degrees : {0.0, 60.0}) {
    Camera camera = *cameraFromView("30,40");
    camera.half_height = 5;
    setFieldOfView(camera, degrees * M_PI / 180);
    AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
    const Vec3d target = plan.found().mesh->vertices[plan.found().mesh->triangles[700][0]];
    const auto [x, y] = pixelOf(camera, target, 400, 300);
    ASSERT_TRUE(
        runAppCommand(context, "import.trim-lasso", wordsOf({x - 1, y - 1, x + 1, y - 1, x + 1, y + 1, x - 1, y + 1})));
    const auto& left = plan.mesh()->vertices;
    EXPECT_EQ(std::find(left.begin(), left.end(), target), left.end()) << degrees;
    EXPECT_LT(plan.trimmed()->triangles_removed, 40u) << "through both walls, and no more";
    ASSERT_TRUE(runAppCommand(context, "import.trim-reset"));
  }
}

TEST_F(ImportCommandsTest, WithoutAChoiceItIsTheCaseThatFileOpenMakes) {
  Workbench bench(options());
  const std::string file = "\"" + block().string() + "\"\nwait\n";
  ASSERT_TRUE(play(bench, "file.open " + file + "import.read " + file + "import.start\nwait\n"));
  EXPECT_EQ(cases(), 1u);
}

TEST_F(ImportCommandsTest, ARemedyThatFailsLeavesThePlanForAnother) {
  Workbench bench(options());
  const auto played =
      play(bench, "import.read \"" + bowl().string() + "\"\nwait\nimport.close holes\nimport.start\nwait\n");
  EXPECT_FALSE(played);
  EXPECT_FALSE(bench.document->isOpen());
  ASSERT_TRUE(bench.imports->plan());
  ASSERT_TRUE(bench.imports->plan()->setClosing({}));
  bench.imports->start();
  do bench.update();
  while (bench.jobs->running());
  EXPECT_TRUE(bench.document->isOpen()) << bench.notices->list().back().text;
}

TEST_F(ImportCommandsTest, AScanThatIsPutAwayLeavesTheSessionAlone) {
  Workbench bench(options());
  const std::string file = "\"" + block().string() + "\"\nwait\n";
  ASSERT_TRUE(play(bench, "file.open " + file));
  const auto generation = bench.document->generation();
  ASSERT_TRUE(play(bench, "import.read " + file + "import.cancel\n"));
  EXPECT_FALSE(bench.imports->plan());
  EXPECT_TRUE(bench.document->isOpen());
  EXPECT_EQ(bench.document->generation(), generation);
}

TEST_F(ImportCommandsTest, WhatIsNoScanIsOpenedAtOnce) {
  Workbench bench(options());
  ASSERT_TRUE(play(bench, "file.open \"" + block().string() + "\"\nwait\n"));
  const fs::path prepared = fs::directory_iterator(folder_.path() / "data" / "cases")->path();
  ASSERT_TRUE(play(bench, "import.read \"" + prepared.string() + "\"\nwait\n"));
  EXPECT_FALSE(bench.imports->plan());
  EXPECT_EQ(bench.document->name(), prepared.stem().string());
}

TEST_F(ImportCommandsTest, WhatCannotBeDoneIsSaid) {
  const std::string read = "import.read \"" + block().string() + "\"\nwait\n";
  const fs::path text = folder_.write("text.stl", "no mesh");
  const std::pair<std::string, const char*> cases[] = {{"import.unit mm", "not available now"},
                                                       {"import.start", "not available now"},
                                                       {"import.read", "the path of a scan"},
                                                       {"import.read \"" + text.string() + "\"\nwait", "text.stl"},
                                                       {read + "import.unit", "mm, cm, m, um or inch"},
                                                       {read + "import.unit ell", "mm, cm, m, um or inch"},
                                                       {read + "import.close glue", "automatic, base, holes or wrap"},
                                                       {read + "import.smooth 21", "0 to 20 mm"},
                                                       {read + "import.base round", "horseshoe or full"},
                                                       {read + "import.base full 2mm", "a length in mm"},
                                                       {read + "import.base full 99", "0.5 to 30 mm"},
                                                       {read + "import.plane on", "occlusal plane"},
                                                       {read + "import.plane maybe", "on or off"},
                                                       {read + "import.holes x", "a length in mm"},
                                                       {read + "import.wrap 90", "0.1 to 5 mm"},
                                                       {read + "import.trim-undo", "not available now"},
                                                       {read + "import.trim circle", "lasso, line or off"},
                                                       {read + "import.trim-lasso 0 0 9 0 9", "X Y of 3 to"},
                                                       {read + "import.trim-line 0 0", "X Y of 2 pixels"},
                                                       {read + "import.trim-rim 11", "0 to 10 mm"},
                                                       {read + "import.voxel 0", "auto"},
                                                       {read + "import.voxel 9", "0.02 to 0.5 mm"}};
  for (const auto& [script, words] : cases) {
    Workbench bench(options());
    const auto played = play(bench, script);
    ASSERT_FALSE(played) << script;
    EXPECT_NE(played.error().message().find(words), std::string::npos) << script << ": " << played.error().message();
  }
}

}  // namespace
}  // namespace kerf::import_plan_test
