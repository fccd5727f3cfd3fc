#include "sim/step/step.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "bench/scenes/feed.h"
#include "bench/scenes/practice_block.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/scene/load_scene.h"
#include "tests/sim/block_scene.h"

namespace kerf::step_test {
namespace {

using test::block;
using test::oneTissue;
using test::sampleAt;

using scenes::turned;

scenes::Feed cutSlot(double voxel, const Rigid3& attitude, double energy = 1000) {
  const auto slot = scenes::slot(voxel, attitude, energy);
  EXPECT_TRUE(slot) << slot.error().message();
  EXPECT_EQ(slot->status, kStepOk);
  return *slot;
}

TEST(Step, ForceAndRemovalRateDoNotDependOnVoxelSize) {
  const Rigid3 attitude = turned(0.3, {1, 2, 3});
  const scenes::Feed coarse = cutSlot(0.1, attitude), fine = cutSlot(0.05, attitude);
  EXPECT_NEAR(coarse.force / fine.force, 1, 0.02);  // goal 5 %
  EXPECT_NEAR(coarse.rate / fine.rate, 1, 0.01);
}

TEST(Step, ForceAndRemovalRateDoNotDependOnTheGridsAttitude) {
  double least = 1e9, most = 0, least_rate = 1e9, most_rate = 0;
  for (int n = 0; n < 8; ++n) {
    const scenes::Feed slot =
        cutSlot(0.1, turned(0.37 * n, {std::sin(2.0 * n), std::cos(3.0 * n), 0.5}, 0.013 * n * Vec3d(1, -2, 0.5)));
    least = std::min(least, slot.force);
    most = std::max(most, slot.force);
    least_rate = std::min(least_rate, slot.rate);
    most_rate = std::max(most_rate, slot.rate);
  }
  EXPECT_LT(most / least, 1.03);
  EXPECT_LT(most_rate / least_rate, 1.03);
}

// Preston: mu N v / u_s, with N the integral of pressure over area.
TEST(Step, RemovalRateIsTheLawsOwn) {
  for (const double energy : {250.0, 500.0, 1000.0, 2000.0}) {
    const scenes::Feed slot = cutSlot(0.05, turned(0.3, {1, 2, 3}), energy);
    EXPECT_NEAR(slot.rate / (0.5 * slot.normal * 840 / energy), 1, 0.05) << energy;
  }
}

TEST(Step, SameInputsSameBits) {
  const auto run = [] {
    Model model;
    model.tools = {practiceBall(0.5, 840)};
    model.tissues = oneTissue(200, 0.5, 1000);
    State state;
    state.objects.emplace_back(block({4, 4, 2}, 0.1, turned(0.2, {0, 1, 1})));
    StepOutput out;
    for (int n = 0; n < 600; ++n)
      step(model, state, sampleAt(turned(0.001 * n, {0, 1, 0}, {0.001 * n, 0, 0.3 - 0.002 * n})), out);
    return state.hash();
  };
  EXPECT_EQ(run(), run());
}

TEST(Step, InTheAirTheHandFeelsNothing) {
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = oneTissue(200, 0.5, 1000);
  State state;
  state.objects.emplace_back(block({6, 6, 2}, 0.1));
  StepOutput out;
  double most = 0;
  // One voxel above the block, to and fro at up to 60 mm/s.
  for (int n = 0; n < 2000; ++n) {
    const double a = 2 * std::numbers::pi * n / 200;
    step(model, state, sampleAt({Eigen::Quaterniond::Identity(), {2 * std::sin(a), 0, 0.1}}), out);
    EXPECT_EQ(out.touching, 0);
    if (n > 100) most = std::max(most, out.force.force.norm());
  }
  // The hand feels the inertia of a virtual tool of 20 g, moved to and fro: some hundredths of a newton at these 60
  // m/s^2.
  EXPECT_LT(most, 0.1);
  // At constant speed there is no force.
  for (int n = 0; n < 1000; ++n) {
    step(model, state, sampleAt({Eigen::Quaterniond::Identity(), {-2 + 0.005 * n, 0, 0.1}}), out);
    if (n > 300) {
      ASSERT_LT(out.force.force.norm(), 0.002);
    }
  }
  EXPECT_EQ(state.objects[0].bricks().changedField().brickCount(), 0u);
}

TEST(Step, AFastPathCutsWhatASlowOneCuts) {
  const auto removed = [](double step_mm) {
    Model model;
    model.tools = {practiceBall(0.5, 840)};
    model.tissues = oneTissue(200, 0.5, 1000);
    model.settings.rendering = Rendering::kRigid;
    model.settings.geometry_only = true;
    State state;
    state.objects.emplace_back(block({8, 4, 3}, 0.05, turned(0.3, {1, 2, 3})));
    const Rigid3 attitude = turned(0.3, {1, 2, 3});
    StepOutput out;
    double sum = 0;
    for (double x = -6; x <= 6; x += step_mm) {
      step(model, state, sampleAt({attitude.rotation, attitude * Vec3d(x, 0, -0.4)}), out);
      sum += out.removed_mm3;
    }
    return sum;
  };
  const double slow = removed(0.01);
  EXPECT_NEAR(removed(0.5) / slow, 1, 0.005);
  EXPECT_NEAR(removed(3.0) / slow, 1, 0.005);
}

// 0.5 m/s against a wall of 0.3 mm: half a millimetre a tick.
TEST(Step, AHandOfHalfAMetrePerSecondDoesNotPassAThinWall) {
  for (const double voxel : {0.1, 0.05}) {
    Model model;
    model.tools = {practiceBall(0.5, 840)};
    model.tissues = oneTissue(200, 0.5, 1000);
    State state;
    state.objects.emplace_back(block({8, 8, 0.3}, voxel, turned(0.3, {1, 0, 3})));
    const Rigid3 wall = turned(0.3, {1, 0, 3});
    StepOutput out;
    bool was_touched = false;
    for (int n = 0; n < 400; ++n) {
      const double z = std::max(10 - 0.5 * n, -40.0);  // ends 40 mm beyond: the coupling gives way at its limit
      step(model, state, sampleAt({wall.rotation, wall * Vec3d(0, 0, z)}, 0), out);
      was_touched |= out.touching > 0;
      ASSERT_GT((wall.inverse() * out.T_world_tool.translation)[2], -0.45) << n;
    }
    EXPECT_TRUE(was_touched);
    EXPECT_GT(out.force.force.norm(), 4);
  }
}

TEST(Step, AStillToolDoesNotCut) {
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = oneTissue(200, 0.5, 1000);
  State state;
  state.objects.emplace_back(block({4, 4, 2}, 0.1));
  StepOutput out;
  for (int n = 0; n < 500; ++n)
    step(model, state, sampleAt({Eigen::Quaterniond::Identity(), {0, 0, 0.2 - 0.002 * n}}, 0), out);
  EXPECT_GT(out.normal_load, 0.3);
  EXPECT_EQ(state.objects[0].bricks().changedField().brickCount(), 0u);
}

// A flat end of 5 mm^2 overlaps by many newtons in the millisecond of its landing. Its momentum over that time is the
// force that stops it, and the reported force.
TEST(Step, TheForceOnAToolThatLandsIsWhatStopsIt) {
  const auto file = findToolFile("909-040", defaultToolFolders());
  ASSERT_TRUE(file);
  const auto wheel = readTool(*file);
  ASSERT_TRUE(wheel);
  StepSettings settings;
  settings.ramp_s = 0;
  auto model = makeModel(std::span(&*wheel, 1), settings);
  ASSERT_TRUE(model);
  const auto enamel = practiceBlock({6, 6, 2}, 0.1, {}, Material::kEnamel);
  ASSERT_TRUE(enamel);
  State state;
  state.objects.emplace_back(*enamel, 64);

  StepOutput out;
  double most_load = 0, most_force = 0;
  for (int n = 0; n < 200; ++n) {
    const Vec3d before = state.body.velocity;
    step(*model, state, sampleAt({Eigen::Quaterniond::Identity(), {0, 0, 0.5 - 0.025 * n}}, 0), out);
    if (n == 0) continue;  // put down
    ASSERT_EQ(out.substeps, 1) << n;
    const Vec3d gained = model->settings.coupling.mass() / kTick * (state.body.velocity - before);
    ASSERT_LT((out.contact.force - gained - out.force.force).norm(), 1e-9) << n;
    most_load = std::max(most_load, out.normal_load);
    if (n < 40) most_force = std::max(most_force, out.contact.force.norm());
  }
  EXPECT_GT(most_load, 10);
  EXPECT_LT(most_force, 3);
  EXPECT_NEAR(out.contact.force[2], out.force.force[2], 0.1);
}

TEST(Step, ABadSampleStopsForceAndCuttingUntilCleared) {
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = oneTissue(200, 0.5, 1000);
  State state;
  state.objects.emplace_back(block({4, 4, 2}, 0.1));
  StepOutput out;
  const DeviceSample pressed = sampleAt({Eigen::Quaterniond::Identity(), {0, 0, -1}});
  for (int n = 0; n < 300; ++n) step(model, state, pressed, out);
  EXPECT_GT(out.force.force.norm(), 0.3);

  DeviceSample bad = pressed;
  bad.T_world_device.translation[1] = std::numeric_limits<double>::quiet_NaN();
  step(model, state, bad, out);
  EXPECT_EQ(out.status, kStepBadSample);
  EXPECT_EQ(out.force.force.norm(), 0);
  const std::uint64_t field = state.objects[0].stateHash();
  for (int n = 0; n < 10; ++n) {
    step(model, state, pressed, out);
    EXPECT_EQ(out.force.force.norm(), 0);  // latched
  }
  EXPECT_EQ(state.objects[0].stateHash(), field);

  state.clearLatch();
  step(model, state, pressed, out);
  EXPECT_EQ(out.status & kStepBadSample, 0u);
  EXPECT_LT(out.force.force.norm(), 2.1);  // fades in

  for (DeviceSample broken : {pressed, pressed, pressed, pressed}) {
    static int kind = 0;
    switch (kind++) {
      case 0:
        broken.T_world_device.rotation.coeffs() *= 1.1;
        break;
      case 1:
        broken.pedal = 1.5;
        break;
      case 2:
        broken.is_valid = 0;
        break;
      default:
        broken.T_world_device.translation[0] = std::numeric_limits<double>::infinity();
    }
    EXPECT_FALSE(broken.isUsable());
  }
}

// Clockwise seen from the shank: a bur pressed with its -x side climbs against the motion of its own surface.
TEST(Step, ASpinningBurPushesItselfAlong) {
  Model model;
  model.tools = {practiceBall(0.8, 0)};
  model.tools[0].motion = ToolMotion::kSpin;
  model.tools[0].drive = {2000, 0, 0, 50};
  model.tools[0].equator_mm = 0.8;
  model.tissues = oneTissue(200, 0.3, 1000);
  model.settings.rendering = Rendering::kRigid;
  State state;
  // The block's top faces -x of the tool: x <= 0 is tissue.
  state.objects.emplace_back(block({8, 8, 4}, 0.1, turned(std::numbers::pi / 2, {0, 1, 0})));
  StepOutput out;
  for (int n = 0; n < 60; ++n) step(model, state, sampleAt({Eigen::Quaterniond::Identity(), {0.79, 0, -0.8}}), out);
  ASSERT_GT(out.normal_load, 0.01);
  EXPECT_GT(out.contact.force[0], 0);
  // omega = -z, r = -x: the surface moves along +y, the tissue drags it back.
  EXPECT_LT(out.contact.force[1], 0);
  EXPECT_NEAR(-out.contact.force[1] / out.contact.force[0], 0.3, 0.05);
  EXPECT_GT(out.contact.torque[2], 0);  // against the spin
  EXPECT_NEAR(out.contact.torque[2], out.drive_load, 0.1 * out.drive_load);
}

// The speed of a bur with its side pressed to a wall for two seconds.
double speedPressed(double force, const char* handpiece) {
  const auto file = findToolFile("856-016", defaultToolFolders());
  EXPECT_TRUE(file);
  Tool tool = *readTool(*file);
  tool.drive.handpiece = findHandpiece(handpiece);
  Model model;
  model.tools = {makeToolModel(tool)};
  model.tissues = oneTissue(200, 0.3, 4200);
  State state;
  state.objects.emplace_back(block({10, 10, 6}, 0.1, turned(std::numbers::pi / 2, {0, 1, 0})));
  StepOutput out;
  for (int n = 0; n < 2000; ++n) {
    const double reach = out.T_world_tool.translation[0];
    step(model, state,
         sampleAt({Eigen::Quaterniond::Identity(), {n == 0 ? 2.0 : std::max(reach - force, reach - 0.02 * n), 0, -2}}),
         out);
  }
  return out.speed / model.tools[0].drive.speed;
}

TEST(Step, ATurbineSagsUnderALightHandAndStallsUnderAHeavyOne) {
  const double light = speedPressed(0.5, "turbine"), firm = speedPressed(1.5, "turbine");
  EXPECT_GT(light, 0.7);
  EXPECT_LT(light, 0.95);
  EXPECT_GT(firm, 0.2);
  EXPECT_LT(firm, light - 0.15);
  EXPECT_EQ(speedPressed(6, "turbine"), 0);
}

TEST(Step, AnElectricDriveHoldsItsSpeed) {
  const double speed = speedPressed(3, "electric");
  EXPECT_LT(speed, 1);
  EXPECT_GT(speed, 0.97);
}

TEST(Step, AFaceThatLooksAwayDoesNotPushTheToolThrough) {
  // A thin plate with the ball's middle beyond it: nodes of the far side would push it onwards.
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = oneTissue(200, 0, 1000);
  model.settings.rendering = Rendering::kRigid;
  State state;
  state.objects.emplace_back(block({8, 8, 0.3}, 0.05));
  StepOutput out;
  double last = 0;
  for (const double depth : {0.1, 0.2, 0.3, 0.4}) {
    step(model, state, sampleAt({Eigen::Quaterniond::Identity(), {0, 0, -depth}}, 0), out);
    EXPECT_GT(out.contact.force[2], last) << depth;
    last = out.contact.force[2];
  }
}

TEST(Step, LongestSubstepFollowsVoxelAndTool) {
  ToolModel blade;
  blade.finest_mm = 0.4;
  blade.smallest_radius_mm = 0.2;
  EXPECT_DOUBLE_EQ(longestSubstep(blade, 0.1), std::sqrt(0.4 * 0.1 * 0.2));
  blade.finest_mm = 0.1;
  EXPECT_DOUBLE_EQ(longestSubstep(blade, 0.1), 0.05);
}

}  // namespace
}  // namespace kerf::step_test
