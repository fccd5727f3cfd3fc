// The removed volume matches the work of the drive, even where the shell's areas err beside an edge.
#include <gtest/gtest.h>

#include <cmath>

#include "bench/scenes/feed.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/sink.h"
#include "geometry/tool/tool_file.h"
#include "sim/object/cut_area.h"
#include "tests/sim/block_scene.h"
#include "tests/support/places.h"

namespace kerf::cut_area_test {
namespace {

TEST(CutArea, NothingCutLeavesAreasAlone) {
  EXPECT_EQ(CutArea().scale(0.1), 1);
  CutArea once;
  once.add(1e-9, 0.5e-9, 0, 0.001);
  EXPECT_NEAR(once.scale(0.1), 1, 1e-4);
}

TEST(CutArea, FollowsTheRatioWithinBounds) {
  CutArea area;
  for (int n = 0; n < 1000; ++n) area.add(1.2e-3, 1e-3, 0, kTick);
  EXPECT_NEAR(area.scale(0.1), 1.2, 1e-3);
  for (int n = 0; n < 2000; ++n) area.add(9e-3, 1e-3, 0, kTick);
  EXPECT_NEAR(area.scale(0.1), 4, 0.01);
  EXPECT_GT(area.share(0.1), 0.99);
  for (int n = 0; n < 500; ++n) area.fade(kTick);
  EXPECT_LT(area.scale(0.1), 1.15) << "half a second later little of it is known";
  EXPECT_LT(area.share(0.1), 0.05);
}

TEST(CutArea, KnowsNothingBeforeSomethingWasCut) {
  EXPECT_EQ(CutArea().share(0.1), 0);
  CutArea little;
  little.add(1e-3 / 30, 1e-3 / 30, 0, kTick);  // a thirtieth of a voxel
  EXPECT_NEAR(little.share(0.1), 0.5, 0.05);
}

// The factor follows a changed ratio within kTime; with unpaid work included, within half of it.
TEST(CutArea, WithWhatIsUnpaidItFollowsTwiceAsFast) {
  constexpr double kShell = 1e-3;
  CutArea late, soon;
  const auto cut = [&](double ratio, double seconds) {
    for (int n = 0; n < seconds / kTick; ++n) {
      late.add(ratio * kShell, kShell, 0, kTick);
      soon.add(ratio * kShell, kShell, (ratio - soon.scale(0.1)) * kShell, kTick);
    }
  };
  cut(1, 3);
  EXPECT_NEAR(soon.scale(0.1), 1, 0.001);
  cut(2, CutArea::kTime / 2);
  EXPECT_NEAR(late.scale(0.1), 2 - std::exp(-0.5), 0.01);
  EXPECT_NEAR(soon.scale(0.1), 2 - std::exp(-1.0), 0.01);
  cut(2, 3);
  EXPECT_NEAR(soon.scale(0.1), 2, 0.001);
}

Model modelOf(const char* id) {
  const auto tool = readTool(std::string(kSourceFolder) + "/assets/tools/" + id + ".toml");
  EXPECT_TRUE(tool) << tool.error().message();
  Model model;
  model.tools = {makeToolModel(*tool)};
  model.tools[0].drive.stall_load = 0;
  model.tissues = test::oneTissue(200, 0.3, 1000);
  model.settings.rendering = Rendering::kRigid;
  return model;
}

State stateWith(const Model& model, double voxel) {
  State state;
  state.objects.reserve(kMostObjects);
  state.objects.emplace_back(test::block({6, 5, 3}, voxel, scenes::askew()), 8192);
  state.speed = model.tools[0].drive.speed;
  return state;
}

// A bur of the rack cuts a slot 0.6 mm deep at 0.1 mm voxels, its drive holding its speed.
struct Slot {
  double paid = 0, removed = 0;  // mm^3/s: paid by the work of the drive
};
Slot slotOf(const char* id, double voxel) {
  Model model = modelOf(id);
  State state = stateWith(model, voxel);
  const ToolDrive& drive = model.tools[0].drive;
  const Rigid3 from{Eigen::Quaterniond::Identity(), {-0.3, 0.013, -0.6}};

  // The tool's own shape first, so that the means cover a steady slot.
  model.settings.geometry_only = true;
  StepOutput out;
  step(model, state, test::sampleAt(scenes::askew() * from), out);
  model.settings.geometry_only = false;
  const scenes::Feed slot = scenes::feed(model, state, scenes::askew(), from, {0.6, 0, 0}, 1, 0.3);
  return {slot.drag * drive.speed / (1000 * drive.energy_factor), slot.rate};
}

// Pose of a blade in the block's frame, its foremost point at that depth, mm.
Rigid3 bladeAt(const Model& model, double depth) {
  const Vec3d& first = model.tools[0].plunge_direction;
  const Eigen::Quaterniond down = Eigen::Quaterniond::FromTwoVectors(first, -Vec3d::UnitZ());
  const Vec3d middle = down * model.tools[0].cut.bounds().center();
  const double lowest = (down * scenes::foremost(model.tools[0], first))[2];
  return {down, Vec3d(0.011 - middle[0], 0.013 - middle[1], -depth - lowest)};
}

// The mean thrust of a blade fed down at 1 mm/s, from 0.3 mm deep on, N.
double thrustOf(const char* id, double voxel) {
  Model model = modelOf(id);
  State state = stateWith(model, voxel);
  model.settings.geometry_only = true;
  StepOutput out;
  for (int n = 0; n <= 40; ++n) step(model, state, test::sampleAt(scenes::askew() * bladeAt(model, 0.3 * n / 40)), out);
  model.settings.geometry_only = false;
  return scenes::feed(model, state, scenes::askew(), bladeAt(model, 0.3), {0, 0, -0.4}, 1, 0.4).thrust;
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

// Levels of the field round the edges of a blade in arcs with tilted normals. At a rim two voxels wide they changed the
// thrust by 6 % against a fine one.
TEST(CutArea, ABladesThrustDoesNotDependOnTheVoxel) {
  for (const char* id : {"disc-22", "saw-sagittal-10", "saw-reciprocating-25"}) {
    const double coarse = thrustOf(id, 0.1), fine = thrustOf(id, 0.05);
    ASSERT_GT(fine, 0.5) << id;
    EXPECT_NEAR(coarse / fine, 1, 0.03) << id;
  }
}

// The normal load, N, after a tool was fed and its drive has fallen to that share of its free speed.
double loadAt(const char* id, double speed) {
  Model model = modelOf(id);
  State state = stateWith(model, 0.1);
  const bool is_blade = model.tools[0].flank_axis >= 0;
  const Rigid3 from = is_blade ? bladeAt(model, 0.3) : Rigid3{Eigen::Quaterniond::Identity(), {-0.3, 0.013, -0.6}};
  const Vec3d way = is_blade ? Vec3d(0, 0, -0.4) : Vec3d(0.4, 0, 0);

  model.settings.geometry_only = true;
  StepOutput out;
  step(model, state, test::sampleAt(scenes::askew() * from), out);
  model.settings.geometry_only = false;
  scenes::feed(model, state, scenes::askew(), from, way, 1, 0.3);

  state.speed = speed * model.tools[0].drive.speed;
  const Rigid3 end = scenes::askew() * Rigid3{from.rotation, from.translation + 1.02 * way};
  step(model, state, test::sampleAt(end, 0), out);
  return out.normal_load;
}

// The edge factor from cutting does not apply to a drive at rest: it fades instead of jumping.
TEST(CutArea, TheLoadDoesNotJumpWhereTheDriveComesToRest) {
  for (const char* id : {"disc-22", "837-012", "859-012"}) {
    const double rest = loadAt(id, 0);
    ASSERT_GT(rest, 0.1) << id;
    EXPECT_NEAR(loadAt(id, 0.001) / rest, 1, 0.01) << id;
    EXPECT_GT(std::abs(loadAt(id, 0.1) / rest - 1), 0.02) << id << ": there is something to fade";
  }
}

}  // namespace
}  // namespace kerf::cut_area_test
