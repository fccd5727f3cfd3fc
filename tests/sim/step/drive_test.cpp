// Turbines, motors and drills, against their formulas.
#include "sim/step/drive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench/scenes/hold.h"
#include "bench/scenes/practice_block.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/scene/load_scene.h"
#include "sim/step/erode_brick.h"
#include "tests/support/places.h"

namespace kerf::drive_test {
namespace {

// Speed after some time at constant pedal and load.
double run(const ToolDrive& drive, double speed, double pedal, double load, double seconds) {
  for (int n = 0; n < static_cast<int>(std::lround(seconds / kTick)); ++n)
    speed = speedAfterTick(drive, speed, pedal, load);
  return speed;
}

ToolDrive turbine() {
  ToolDrive drive{1000, 1, 0.32, 1, 1};
  drive.form = DriveForm::kTurbine;
  drive.run_down = 3.2;
  return drive;
}

ToolDrive motor() {
  ToolDrive drive{1000, 20, 0.3, 1, 1};
  drive.form = DriveForm::kGoverned;
  drive.droop = 0.02;
  return drive;
}

TEST(Drive, ATurbineComesUpByItsTimeConstantAndRunsDownByItsBearing) {
  for (const double t : {0.1, 0.32, 1.0})
    EXPECT_NEAR(run(turbine(), 0, 1, 0, t), 1000 * (1 - std::exp(-t / 0.32)), 1e-6) << t;
  EXPECT_NEAR(run(turbine(), 1000, 0, 0, 1.6), 500, 1e-6);
  EXPECT_GT(run(turbine(), 1000, 0, 0, 3.1), 0);
  EXPECT_EQ(run(turbine(), 1000, 0, 0, 3.21), 0);
}

TEST(Drive, ATurbineLosesSpeedInProportionToTheLoadAndStalls) {
  for (const double load : {0.1, 0.5, 0.9}) EXPECT_NEAR(run(turbine(), 1000, 1, load, 10), 1000 * (1 - load), 1e-6);
  // Standstill torque is proportional to the square of the pedal, free speed to the pedal.
  EXPECT_NEAR(run(turbine(), 0, 0.5, 0, 20), 500, 1e-6);
  EXPECT_NEAR(run(turbine(), 0, 0.5, 0.125, 20), 250, 1e-6);
  EXPECT_EQ(run(turbine(), 0, 0.5, 0.26, 1), 0);
  // Stalls, stays stalled, and recovers.
  const double stalled = run(turbine(), 1000, 1, 1.3, 2);
  EXPECT_EQ(stalled, 0);
  EXPECT_EQ(run(turbine(), stalled, 1, 1.01, 1), 0);
  EXPECT_NEAR(run(turbine(), stalled, 1, 0.4, 10), 600, 1e-6);
}

TEST(Drive, AMotorHoldsItsSpeedUpToItsTorque) {
  EXPECT_NEAR(run(motor(), 0, 1, 0, 2), 1000, 0.1);
  EXPECT_NEAR(run(motor(), 1000, 1, 0.5, 2), 990, 0.1);
  EXPECT_NEAR(run(motor(), 1000, 1, 0.99, 5), 1000 * (1 - 0.02 * 0.99), 0.1);
  EXPECT_EQ(run(motor(), 1000, 1, 1.5, 2), 0);
  EXPECT_NEAR(run(motor(), 0, 1, 0.5, 2), 990, 0.1);
  // Its torque limits acceleration both ways.
  EXPECT_NEAR(run(motor(), 0, 1, 0, 0.15), 500, 1);
  EXPECT_NEAR(run(motor(), 1000, 0, 0, 0.15), 500, 1);
  EXPECT_NEAR(run(motor(), 1000, 1, 1.3, 0.5), 500, 1);
  EXPECT_LT(run(motor(), 1000, 0, 0, 0.5), 10);
}

TEST(Drive, AMotorTurnsBackwardsAsForwardsAndStopsInBetween) {
  for (const double load : {0.0, 0.5, 1.5})
    EXPECT_EQ(run(motor(), 0, -1, load, 2), -run(motor(), 0, 1, load, 2)) << load;

  // From full speed to full speed the other way, through standstill.
  double speed = 1000, before = speed;
  int stood = 0;
  for (int n = 0; n < 1000; ++n) {
    speed = speedAfterTick(motor(), speed, -1, 0.1);
    EXPECT_FALSE(before > 0 && speed < 0) << n;
    stood += speed == 0;
    before = speed;
  }
  EXPECT_GT(stood, 0);
  EXPECT_NEAR(speed, -1000 * (1 - 0.02 * 0.1), 1);
  // A load slows reverse rotation and does not drive it.
  EXPECT_LT(run(motor(), -1000, 0, 0, 0.1), -600);
  EXPECT_GT(run(motor(), -1000, 0, 0.9, 0.1), run(motor(), -1000, 0, 0, 0.1));
}

TEST(Drive, WhatGoesOneWayTakesANegativePedalForOneThatIsUp) {
  ToolDrive line{1000, 1, 0.05, 1, 1};
  EXPECT_FALSE(turnsBackwards(DriveForm::kLine));
  EXPECT_FALSE(turnsBackwards(DriveForm::kTurbine));
  for (const ToolDrive& drive : {turbine(), line}) {
    EXPECT_EQ(run(drive, 0, -1, 0, 1), 0);
    EXPECT_EQ(run(drive, 1000, -1, 0, 0.2), run(drive, 1000, 0, 0, 0.2));
  }
}

TEST(Drive, WithoutATimeItFollowsAtOnceAndWithoutAStallNothingStopsIt) {
  for (const DriveForm form : {DriveForm::kLine, DriveForm::kTurbine, DriveForm::kGoverned}) {
    ToolDrive drive{1000, 0, 0, 1, 1};
    drive.form = form;
    EXPECT_EQ(speedAfterTick(drive, 0, 1, 0), 1000);
    EXPECT_EQ(speedAfterTick(drive, 1000, 0, 0), 0);
    EXPECT_EQ(speedAfterTick(drive, 1000, 0.5, 0), 500);
  }
}

TEST(Drive, SpeedIsNeverNegativeAndNeverAboveFree) {
  for (const DriveForm form : {DriveForm::kLine, DriveForm::kTurbine, DriveForm::kGoverned}) {
    ToolDrive drive = form == DriveForm::kGoverned ? motor() : turbine();
    drive.form = form;
    double speed = 0;
    for (int n = 0; n < 5000; ++n) {
      const double pedal = (n * 7 % 11) / 10.0, load = (n / 37 % 9) / 3.0;
      speed = speedAfterTick(drive, speed, std::min(pedal, 1.0), load);
      ASSERT_GE(speed, 0) << n;
      ASSERT_LE(speed, 1000 * (1 + 1e-12)) << n;
    }
  }
}

// ---- Drills

Model drillAt(const char* id, double rpm) {
  const auto file = findToolFile(id, defaultToolFolders());
  EXPECT_TRUE(file);
  const auto tool = readTool(*file);
  EXPECT_TRUE(tool);
  auto model = makeModel(std::span(&*tool, 1));
  EXPECT_TRUE(model);
  model->settings.coupling.force_limit = 40;
  model->tools[0].drive.speed = rpm * 2 * std::numbers::pi / 60;
  return *model;
}

scenes::HoldScene drillScene(Material material, double force, double seconds) {
  scenes::HoldScene scene;
  const auto block = practiceBlock({5, 5, 7}, 0.1, {}, material);
  EXPECT_TRUE(block);
  scene.object = *block;
  scene.start = {Eigen::Quaterniond::Identity(), {0.011, 0.013, -0.0}};
  scene.force = force;
  scene.seconds = seconds;
  scene.settle = 0.6 * seconds;
  return scene;
}

scenes::Hold drilled(const Model& model, Material material, double force, double seconds) {
  return scenes::hold(model, drillScene(material, force, seconds));
}

// F = K D^1.25 (f + f0): feed per turn by thrust, with the point in the bone.
TEST(Drill, FeedOfATurnFollowsTheThrust) {
  const Model model = drillAt("drill-20", 1500);
  const double per_feed = DrillLips::kThrust * std::pow(2.0, 1.25);
  for (const double force : {8.0, 12.0}) {
    const double feed = force / per_feed - DrillLips::kRubbing;  // mm per turn
    EXPECT_NEAR(drilled(model, Material::kCortical, force, 1.6).feed / (feed * 25), 1, 0.1) << force;
  }
}

// In soft bone a hand has more force than the greatest feed needs. The core holds the excess; without it a narrow drill
// falls through the block.
TEST(Drill, PushedBeyondItsGreatestFeedItIsHeldByItsCore) {
  for (const char* id : {"drill-20", "drill-28", "drill-35"}) {
    const Model model = drillAt(id, 800);
    const double greatest = 2 * model.tools[0].equator_mm * DrillLips::kMostFeed * 800 / 60;  // mm/s
    for (const double force : {16.0, 20.0}) {
      const double feed = drilled(model, Material::kCancellous, force, 1.6).feed;
      EXPECT_GT(feed, 0.99 * greatest) << id << ' ' << force;
      EXPECT_LT(feed, 1.3 * greatest) << id << ' ' << force;
    }
  }

  // The earlier its core holds a drill, the slower it feeds: 1.20 with 0.7 voxels kept instead of one.
  const Model narrow = drillAt("drill-20", 800);
  const double greatest = 2 * narrow.tools[0].equator_mm * DrillLips::kMostFeed * 800 / 60;
  EXPECT_GT(drilled(narrow, Material::kCancellous, 20, 1.6).feed, 1.24 * greatest);

  Model without = narrow;
  without.tools[0].core.clear();
  EXPECT_GT(drilled(without, Material::kCancellous, 20, 1.6).feed, 20);
}

// The lips do not use the core's load for cutting.
TEST(Drill, BelowThatItsCoreTakesNothing) {
  const Model model = drillAt("drill-20", 800);
  Model without = model;
  without.tools[0].core.clear();
  for (const auto& [bone, force] : {std::pair(Material::kCortical, 12.0), std::pair(Material::kCancellous, 3.0)})
    EXPECT_NEAR(drilled(model, bone, force, 1.6).feed / drilled(without, bone, force, 1.6).feed, 1, 0.01) << force;
}

TEST(Drill, BelowAForceItOnlyRubs) {
  const Model model = drillAt("drill-20", 1500);
  const scenes::Hold held = drilled(model, Material::kCortical, 2.5, 1.5);
  EXPECT_LT(held.feed, 0.05);
  EXPECT_GT(held.torque, 0.1);
  // The depth at which the immersed part of the point needs all of the force.
  const double wide = std::pow(2.5 / (DrillLips::kThrust * DrillLips::kRubbing), 1 / 1.25);
  EXPECT_NEAR(held.depth, 0.5 * wide / std::sqrt(3.0), 0.03);
}

// Backing out a drill: its lips rub with their backs, remove nothing, and the torque is reversed.
TEST(Drill, BackwardsItOnlyRubs) {
  const Model model = drillAt("drill-20", 1500);
  scenes::HoldScene scene = drillScene(Material::kCortical, 10, 1.0);
  const scenes::Hold forwards = scenes::hold(model, scene);
  scene.pedal = -1;
  const scenes::Hold backwards = scenes::hold(model, scene);

  EXPECT_GT(forwards.rate, 1);
  EXPECT_EQ(backwards.rate, 0);
  EXPECT_NEAR(backwards.last_speed, -forwards.last_speed, 0.02);
  EXPECT_GT(backwards.torque, 0.1);
}

// Grains have no back: a diamond removes as much in reverse, and pulls the hand to the other side.
TEST(Drive, ADiamondCutsBackwardsAsForwardsAndPullsTheOtherWay) {
  const auto tool = readTool(*findToolFile("856-016", defaultToolFolders()));
  ASSERT_TRUE(tool);
  Tool held = *tool;
  held.drive.handpiece = findHandpiece("electric");
  const auto model = makeModel(std::span(&held, 1));
  ASSERT_TRUE(model);
  ASSERT_TRUE(model->tools[0].cuts_backwards);

  scenes::HoldScene scene;
  scene.object = *practiceBlock({6, 6, 6}, 0.1, {}, Material::kDentin);
  scene.start = {Eigen::Quaterniond(Eigen::AngleAxisd(-std::numbers::pi / 2, Vec3d::UnitX())), {0.01, -3.0, 0.85}};
  scene.force = 0.5;
  scene.seconds = 1.5;
  const scenes::Hold forwards = scenes::hold(*model, scene);
  scene.pedal = -1;
  const scenes::Hold backwards = scenes::hold(*model, scene);
  EXPECT_GT(forwards.rate, 0.01);
  EXPECT_NEAR(backwards.rate / forwards.rate, 1, 0.02);
  EXPECT_GT(std::abs(forwards.aside[0]), 0.02);
  EXPECT_NEAR(backwards.aside[0], -forwards.aside[0], 0.1 * std::abs(forwards.aside[0]));
}

TEST(Drill, OnlyTheDrillsOfTheRackHaveLips) {
  for (const ToolListing& t : listTools({std::filesystem::path(kSourceFolder) / "assets/tools"})) {
    ASSERT_TRUE(t.tool);
    const ToolModel model = makeToolModel(*t.tool, 0.2);
    const bool is_twist = t.tool->id.starts_with("twist-");
    EXPECT_EQ(model.lips.areThere(), t.tool->id.starts_with("drill-") || is_twist) << t.tool->id;
    if (!model.lips.areThere()) continue;
    const double half_angle = (is_twist ? 59 : 60) * std::numbers::pi / 180;
    EXPECT_NEAR(model.lips.slope, std::sin(half_angle), 1e-9);
    EXPECT_NEAR(model.lips.height, 0.5 * t.tool->head_diameter_mm / std::tan(half_angle), 1e-9);
  }
}

// The kernel against its formula, node by node.
TEST(Drill, LipsErodeByTheirFormula) {
  float x[512], y[512], z[512], tau[512], phi[512], rates[512], out[512];
  for (int n = 0; n < 512; ++n) {
    x[n] = 0.002f * static_cast<float>(n);
    y[n] = 0.1f;
    z[n] = n % 2 == 0 ? 0.2f : 0.8f;
    tau[n] = -0.02f;
    phi[n] = -0.0001f * static_cast<float>(n % 100);
    rates[n] = 0.01f * static_cast<float>(1 + n % 7);
  }
  internal::ErodeBrickInput in;
  in.x = x;
  in.y = y;
  in.z = z;
  in.tau = tau;
  in.phi = phi;
  in.rates = nullptr;
  in.rate = 0.3f;
  in.lip_rates = rates;
  in.lever = {internal::LeverForm::kRadius, 0.15f, 0};
  in.lips = {0.5f, 0.0001f, 0.0005f};
  in.cap = 1;
  internal::erodeBrick(in, out);

  for (int n = 0; n < 512; ++n) {
    const double r = std::max(0.15, std::hypot(static_cast<double>(x[n]), 0.1));
    const double overlap = 0.02 - static_cast<double>(phi[n]);
    double gone = overlap * -std::expm1(-0.3 * r);
    if (z[n] < 0.5f) {
      const double over_time = static_cast<double>(rates[n]) * std::pow(r, 0.75);
      gone = std::min(0.0005, std::max(0.0, overlap - 0.0001 / over_time) * -std::expm1(-over_time));
    }
    ASSERT_NEAR(static_cast<double>(out[n]) - static_cast<double>(phi[n]), gone, 2e-7) << n;
  }
}

}  // namespace
}  // namespace kerf::drive_test
