// Work of the drive pays for what is removed, whatever the shell's areas say beside an edge.
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tool/tool_file.h"
#include "sim/object/cut_area.h"
#include "sim/scenes/feed.h"
#include "sim/scenes/poses.h"
#include "tests/sim/block_scene.h"

namespace kerf {
namespace {

TEST(CutArea, NothingCutLeavesAreasAlone) {
  EXPECT_EQ(CutArea().scale(0.1), 1);
  CutArea once;
  once.add(1e-9, 0.5e-9, 0.001);
  EXPECT_NEAR(once.scale(0.1), 1, 1e-5);
}

TEST(CutArea, FollowsTheRatioWithinBounds) {
  CutArea area;
  for (int n = 0; n < 1000; ++n) area.add(1.2e-3, 1e-3, kTick);
  EXPECT_NEAR(area.scale(0.1), 1.2, 1e-3);
  for (int n = 0; n < 2000; ++n) area.add(9e-3, 1e-3, kTick);
  EXPECT_EQ(area.scale(0.1), 2);
  for (int n = 0; n < 3000; ++n) area.fade(kTick);
  EXPECT_NEAR(area.scale(0.1), 1, 0.02);
}

// A bur of the rack draws a slot 0.6 mm deep at 0.1 mm voxels, its drive holding its speed.
struct Slot {
  double paid = 0, removed = 0;  // mm^3/s: what the work of the drive pays for
};
Slot slotOf(const char* id, double voxel) {
  const auto tool = readTool(std::string(KERF_SOURCE_DIR) + "/assets/tools/" + id + ".toml");
  EXPECT_TRUE(tool) << tool.error().message();
  Model model;
  model.tools = {makeToolModel(*tool)};
  model.tools[0].drive.stall_load = 0;
  model.tissues = test::oneTissue(200, 0.3, 1000);
  model.settings.rendering = Rendering::kRigid;

  const auto loaded = test::block({6, 5, 3}, voxel, scenes::askew());
  State state;
  state.objects.reserve(kMostObjects);
  state.objects.emplace_back(loaded, 8192);
  const ToolDrive& drive = model.tools[0].drive;
  state.speed = drive.speed;
  const Rigid3 from{Eigen::Quaterniond::Identity(), {-0.3, 0.013, -0.6}};

  // The tool's own shape first, so that the means are of a steady slot.
  model.settings.geometry_only = true;
  StepOutput out;
  step(model, state, test::sampleAt(scenes::askew() * from), out);
  model.settings.geometry_only = false;
  const scenes::Feed slot = scenes::feed(model, state, scenes::askew(), from, {0.6, 0, 0}, 1, 0.3);
  return {slot.drag * drive.speed / (1000 * drive.energy_factor), slot.rate};
}

TEST(CutArea, WorkPaysForWhatIsRemovedBesideEdgesToo) {
  for (const char* id : {"round-014", "837-012", "847-012", "805-014"}) {
    const Slot slot = slotOf(id, 0.1);
    ASSERT_GT(slot.removed, 0.1) << id;
    EXPECT_NEAR(slot.paid / slot.removed, 1, 0.03) << id;
  }
}

TEST(CutArea, APointThinnerThanThreeVoxelsIsPaidForAsAFineOneIs) {
  const Slot coarse = slotOf("859-012", 0.1), fine = slotOf("859-012", 0.05);
  EXPECT_NEAR(coarse.paid / fine.paid, 1, 0.1);
}

}  // namespace
}  // namespace kerf
