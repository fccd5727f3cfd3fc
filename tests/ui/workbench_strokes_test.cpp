// Strokes on the workbench: removal by tissue, a harder push while Shift is down, and the demo arch, opened like any
// scan.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "geometry/formats/mesh_writer.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/readout/point_readout.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/app/workbench/workbench.h"

namespace kerf::workbench_strokes_test {
namespace {

namespace fs = std::filesystem;

class WorkbenchStrokesTest : public testing::Test {
 protected:
  void begin(double voxel, std::vector<std::string> tools = {"round-014"}) {
    WorkbenchOptions options;
    options.data_folder = folder_.path() / "data";
    options.tools = std::move(tools);
    options.voxel_mm = voxel;
    options.real_time = {.priority = 0, .lock_memory = false};
    bench_ = std::make_unique<Workbench>(options);
  }
  Expected<void> play(const std::string& script) {
    AppContext context{.bench = *bench_, .camera = camera_, .width = 400, .height = 300};
    return runScript(context, folder_.write("script.ks", script), [&] { bench_->update(); });
  }
  // By the simulation's clock.
  void wait(double seconds) {
    const auto until = bench_->document->report().tick + static_cast<std::uint64_t>(seconds / kTick);
    while (bench_->document->report().tick < until) bench_->update();
  }
  std::string said() const {
    std::string out;
    for (const Notice& notice : bench_->notices->list()) out += notice.text + "\n";
    return out;
  }

  TemporaryFolder folder_;
  std::unique_ptr<Workbench> bench_;
  Camera camera_ = *cameraFromView("top");
};

// Labels of a CT: 20 x 20 x 10 voxels of 0.4 mm of cortical bone, with a canal 3 mm wide from 0.4 mm below its top.
std::string boneAndCanal() {
  std::string out =
      "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 24 24 14\nencoding: ascii\nspace: "
      "left-posterior-superior\nspace directions: (0.4,0,0) (0,0.4,0) (0,0,0.4)\nspace origin: (0,0,0)\n"
      "Segment0_LabelValue:=1\nSegment0_Name:=Mandible\nSegment1_LabelValue:=2\nSegment1_Name:=Nerve canal\n\n";
  for (int k = 0; k < 14; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i) {
        const bool is_in = i > 1 && i < 22 && j > 1 && j < 22 && k > 1 && k < 12;
        const bool is_canal = j > 7 && j < 16 && k > 4 && k < 11;
        out += is_in ? is_canal ? "2\n" : "1\n" : "0\n";
      }
  return out;
}

TEST_F(WorkbenchStrokesTest, WhatIsRemovedIsCountedTissueByTissue) {
  begin(0.2);
  const fs::path labels = folder_.write("ct.nrrd", boneAndCanal());
  ASSERT_TRUE(play("file.open \"" + labels.string() + "\"\nwait\nview.top\nview.fit\ncut.force 3\ncut.depth 0.15\n" +
                   "cut.press 200 150\nwait 2\ncut.release\nwait 0.3\n"))
      << said();
  EXPECT_GT(bench_->document->removedOf(Material::kCortical), 0.02);
  EXPECT_NEAR(bench_->document->removedOf(Material::kNerveCanal), 0, 1e-3) << "not that deep yet";
  EXPECT_EQ(bench_->document->removedOf(Material::kEnamel), 0) << "there is none";

  ASSERT_TRUE(play("cut.depth 1.5\ncut.press 200 150\nwait 5\ncut.release\nwait 0.3\n")) << said();
  const double bone = bench_->document->removedOf(Material::kCortical),
               canal = bench_->document->removedOf(Material::kNerveCanal);
  EXPECT_GT(canal, 0.01);
  EXPECT_NEAR(bone + canal, bench_->document->removedMm3(), 1e-6) << "nothing is counted twice or left out";

  ASSERT_TRUE(play("edit.undo\nwait 0.3\nedit.undo\nwait 0.3\n"));
  EXPECT_NEAR(bench_->document->removedOf(Material::kCortical), 0, 1e-9);
  EXPECT_NEAR(bench_->document->removedOf(Material::kNerveCanal), 0, 1e-9);
  ASSERT_TRUE(play("file.close\nwait\n"));
  EXPECT_EQ(bench_->document->removedOf(Material::kCortical), 0) << "nothing is open";
}

TEST_F(WorkbenchStrokesTest, AToolThatRestsOnItsShankIsToldWhileItDoes) {
  begin(0.1, {folder_
                  .write("short.toml",
                         "format = \"kerf-tool\"\nversion = 1\nid = \"short\"\nname = \"Short\"\n"
                         "kind = \"bur\"\nshape = \"round\"\nhead_diameter = 1.0\nneck_diameter = 0.6\n"
                         "neck_length = 0.4\nshank_diameter = 1.6\nshank_length = 8.0\n")
                  .string()});
  const fs::path block = folder_.path() / "block.ply";
  ASSERT_TRUE(writeMesh(block, test::blockMesh(false)));
  ASSERT_TRUE(play("file.open \"" + block.string() +
                   "\"\nwait\nview.top\nview.fit\ncut.force 2\ncut.depth 2.5\ncut.press 200 150\nwait 0.2\n"
                   "expect hindered 0 0\n"))
      << said();
  for (int n = 0; n < 40 && !bench_->monitor->hindrance()[0]; ++n) wait(0.25);
  EXPECT_NE(std::string(bench_->monitor->hindrance()).find("neck or shank rests"), std::string::npos)
      << *bench_->strokes->depthNow() << " mm deep, of the load " << bench_->document->report().output.normal_load
      << " N cuts " << bench_->document->report().output.cutting_load;
  EXPECT_TRUE(play("wait 0.3\nexpect hindered 1 1\nprint\n"));
  EXPECT_TRUE(play("cut.release\nwait 0.1\nexpect hindered 0 0\n"));
  // Neither a cutting stroke nor one at its depth is hindered.
  ASSERT_TRUE(play("cut.depth 0.3\ncut.press 280 150\n"));
  for (int n = 0; n < 12; ++n) {
    wait(0.25);
    EXPECT_STREQ(bench_->monitor->hindrance(), "") << n;
  }
  // A drive at standstill does not cut.
  ASSERT_TRUE(play("cut.depth 2\ncut.speed 0\n"));
  for (int n = 0; n < 60 && !bench_->monitor->hindrance()[0]; ++n) wait(0.25);
  EXPECT_NE(std::string(bench_->monitor->hindrance()).find("drive stalled"), std::string::npos);
  ASSERT_TRUE(play("cut.release\nwait 0.1\n"));
}

TEST_F(WorkbenchStrokesTest, TissueAndPointAreThoseUnderTheToolDuringAStroke) {
  begin(0.2);
  const fs::path labels = folder_.write("ct.nrrd", boneAndCanal());
  ASSERT_TRUE(play("file.open \"" + labels.string() + "\"\nwait\nview.top\nview.fit\ncut.force 3\ncut.depth 0.15\n"))
      << said();
  EXPECT_FALSE(readoutOfTool(*bench_));
  ASSERT_TRUE(play("cut.press 200 150\n"));
  const Vec3d pressed = bench_->strokes->pointer();
  for (int n = 0; n < 10; ++n) {  // in air, while it cuts, and at its depth
    wait(0.2);
    const auto under = readoutOfTool(*bench_);
    ASSERT_TRUE(under) << n;
    EXPECT_EQ(under->tissue, bench_->document->nameOf(Material::kCortical)) << n;
    EXPECT_LT((under->point - pressed).norm(), 0.4) << n;
  }
  bench_->strokes->deepen(1.2);
  std::optional<PointReadout> deep;
  for (int n = 0; n < 100 && !(deep && deep->tissue == bench_->document->nameOf(Material::kNerveCanal)); ++n) {
    wait(0.1);
    deep = readoutOfTool(*bench_);
    ASSERT_TRUE(deep);
  }
  EXPECT_EQ(deep->tissue, bench_->document->nameOf(Material::kNerveCanal));
  EXPECT_GT((deep->point - pressed).norm(), 0.3);
  ASSERT_TRUE(play("cut.release\nwait 0.1\n"));
  EXPECT_FALSE(readoutOfTool(*bench_)) << "the cursor has its own";
}

TEST_F(WorkbenchStrokesTest, ASessionThatEndsTellsItsNumbers) {
  begin(0.2);
  const fs::path labels = folder_.write("ct.nrrd", boneAndCanal());
  ASSERT_TRUE(play("file.open \"" + labels.string() +
                   "\"\nwait\nview.top\nview.fit\ncut.force 4\ncut.depth 1.4\ncut.press 200 150\nwait 5\n"
                   "cut.release\nwait 0.3\nedit.undo\nwait 0.3\ncut.force 1\ncut.depth 0.1\ncut.press 200 150\n"
                   "wait 3\ncut.release\nwait 0.3\n"))
      << said();
  const double bone = bench_->document->removedOf(Material::kCortical);
  ASSERT_TRUE(play("file.close\nwait\nprint\n"));
  const auto& told = bench_->sessions->lastResult();
  ASSERT_TRUE(told) << said();
  ASSERT_TRUE(bench_->sessions->debrief());
  EXPECT_NE(bench_->sessions->debrief()->text.find("cortical bone 0."), std::string::npos);
  EXPECT_TRUE(fs::exists(bench_->sessions->debrief()->folder / "run.toml"));
  EXPECT_NEAR(told->removed_by_material.at("cortical"), bone, 1e-6);
  EXPECT_TRUE(told->mean_contact_force && told->contact_force && told->hottest && told->seconds);
  // The stroke into the canal was undone.
  ASSERT_TRUE(told->least_distance.at("nerve_canal"));
  EXPECT_GT(told->least_distance.at("nerve_canal")->value, 0.05);
  EXPECT_LT(told->taken_back.least_distance.at("nerve_canal").value, 0);
  EXPECT_GT(told->taken_back.contact_force.value().value, told->contact_force->value);
  for (const char* const words : {"Removed 0.", "cortical bone 0.", "N mean", "Nearest to the", "in an undone stroke",
                                  "Warmest tissue", "Session saved"})
    EXPECT_NE(said().find(words), std::string::npos) << words << " in " << said();
}

TEST_F(WorkbenchStrokesTest, PushedHarderAStrokePushesTwiceAsHardUntilThatEnds) {
  begin(0.1);
  const fs::path block = folder_.path() / "block.ply";
  // High enough that the bur does not reach its limit before the test ends, even if this thread is late.
  ASSERT_TRUE(writeMesh(block, test::blockMesh(false, {6, 4, 7})));
  ASSERT_TRUE(play("file.open \"" + block.string() +
                   "\"\nwait\nview.fit\ncut.force 0.6\ncut.depth 5\ncut.press 200 150\nwait 1.5\n"))
      << said();
  // The mean of a second over all its reports, as the force wavers in a deepening kerf. At least a hundred reports.
  const auto felt = [&] {
    constexpr int kLeast = 100;
    double sum = 0;
    int reports = 0;
    std::uint64_t last = bench_->document->report().tick;
    for (const std::uint64_t end = last + 1000; last < end || reports < kLeast;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      bench_->update();
      if (bench_->document->report().tick == last) continue;
      last = bench_->document->report().tick;
      sum += bench_->document->report().output.force.force[2];
      ++reports;
    }
    return sum / reports;
  };
  EXPECT_NEAR(felt(), 0.6, 0.06);
  bench_->strokes->pushHarder(2);
  wait(0.3);
  EXPECT_NEAR(felt(), 1.2, 0.12);
  EXPECT_EQ(bench_->strokes->force, 0.6) << "the slider stays";
  bench_->strokes->pushHarder(1);
  wait(0.3);
  EXPECT_NEAR(felt(), 0.6, 0.06);

  // Not beyond the maximum force of a hand.
  bench_->strokes->setForce(Strokes::kMostForce);
  bench_->strokes->pushHarder(2);
  wait(0.3);
  EXPECT_LE(felt(), Strokes::kMostForce * 1.05);
}

TEST_F(WorkbenchStrokesTest, TheDemoArchOpensAndIsCut) {
  begin(0.3);
  ASSERT_TRUE(play("file.demo arch\nwait\n")) << said();
  ASSERT_TRUE(bench_->document->isOpen());
  EXPECT_EQ(bench_->document->name(), "arch");
  EXPECT_TRUE(bench_->document->occlusal().arch) << "a full arch: its teeth have sides";
  EXPECT_TRUE(bench_->document->occlusal().normal);

  // Viewed from above, on the first object along the middle row of pixels.
  ASSERT_TRUE(play("view.top\nview.fit\ncut.force 2\n"));
  int x = 0;
  while (x < 400 && !bench_->strokes->over(rayUnder(camera_, x, 150, 400, 300))) x += 4;
  ASSERT_LT(x, 400) << "nothing is in the picture";
  const auto cut =
      play(fmt::format("cut.press {} 150\nwait 3\ncut.release\nwait 0.3\nexpect removed 0.05 50\n", x + 8));
  EXPECT_TRUE(cut) << cut.error().message();
}

}  // namespace
}  // namespace kerf::workbench_strokes_test
