#include "sim/hand/virtual_hand.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "bench/scenes/press.h"
#include "geometry/tool/sweep.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/sweep/sweep_cutter.h"
#include "tests/sim/block_scene.h"
#include "tests/support/slice.h"

namespace kerf::virtual_hand_test {
namespace {

using scenes::turned;
using test::block;
using test::oneTissue;

CutPath straight(const Vec3d& from, const Vec3d& to, double seconds) {
  CutPath path;
  for (const auto& [t, p] : {std::pair(0.0, from), std::pair(seconds, to)})
    path.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}});
  path.cuts = {1};
  return path;
}

TEST(VirtualHand, FeedHandGoesThePathInItsTime) {
  const CutPath path = straight({0, 0, 1}, {0, 0, -1}, 0.5);
  FeedHand hand(path);
  StepOutput out;
  DeviceSample sample;
  int ticks = 0;
  while (hand.next(out, sample)) {
    EXPECT_NEAR(sample.T_world_device.translation[2], std::max(1 - 4 * kTick * ticks, -1.0), 1e-9);
    ++ticks;
  }
  EXPECT_EQ(ticks, 501);
  EXPECT_EQ(hand.progress(), 1);
}

struct Plunge {
  double rate = 0, spread = 0, load = 0;
};
// A ball pressed with constant force into a block, its surface moving at 840 mm/s, measured after its equator has
// entered.
Plunge plunge(double force, double voxel) {
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = oneTissue(200, 0.5, 1000);
  model.settings.coupling.stiffness = ForceHand::kStiffness;
  State state;
  state.objects.emplace_back(block({3, 3, 4}, voxel));
  const CutPath path = straight({0.01, 0.02, 0.05}, {0.01, 0.02, -3}, 1);
  ForceHand::Options options;
  options.force = force;
  ForceHand hand(path, model.settings.coupling, options);
  StepOutput out;
  DeviceSample sample;
  state.place(poseAt(path, 0));

  std::vector<double> rates, loads;
  double sum = 0, load = 0;
  int n = 0;
  while (hand.next(out, sample)) {
    step(model, state, sample, out);
    if (out.T_world_tool.translation[2] > -1 || out.T_world_tool.translation[2] < -2.5) continue;
    sum += out.removed_mm3;
    load += out.normal_load;
    if (++n % 50 == 0) {
      rates.push_back(sum / (50 * kTick));
      loads.push_back(load / 50);
      sum = load = 0;
    }
  }

  EXPECT_FALSE(hand.gaveUp());
  EXPECT_GE(rates.size(), 4u);
  Plunge result;
  double least = 1e9, most = 0;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    result.rate += rates[i] / static_cast<double>(rates.size());
    result.load += loads[i] / static_cast<double>(loads.size());
    least = std::min(least, rates[i]);
    most = std::max(most, rates[i]);
  }
  result.spread = (most - least) / result.rate;
  return result;
}

TEST(VirtualHand, ConstantForceRemovesSteadilyAndInProportion) {
  std::vector<double> loads, rates;
  for (const double force : {0.5, 1.0, 2.0, 3.0}) {
    const Plunge p = plunge(force, 0.1);
    // The count steps where the surface crosses the grid, so windows of a slow cut are a little rough.
    EXPECT_LT(p.spread, 0.035) << force;
    // N is 3/2 of the force on a hemisphere with pressure proportional to its overlap.
    EXPECT_NEAR(p.rate / (0.5 * p.load * 840 / 1000), 1, 0.05) << force;
    EXPECT_NEAR(p.load / force, 1.5, 0.1) << force;
    loads.push_back(p.load);
    rates.push_back(p.rate);
  }
  double mean = 0, total = 0, residual = 0;
  for (const double r : rates) mean += r / 4;
  for (std::size_t n = 0; n < 4; ++n) {
    total += std::pow(rates[n] - mean, 2);
    residual += std::pow(rates[n] - 0.5 * loads[n] * 840 / 1000, 2);
  }
  EXPECT_GT(1 - residual / total, 0.98);
}

// Removed volume of a ball of 1 mm along a path with two corners, over its swept volume.
double shareOfThePlan(double force, double voxel) {
  Model model;
  model.tools = {practiceBall(0.5, 8400)};
  model.tissues = oneTissue(200, 0.3, 1000);
  model.settings.coupling.stiffness = ForceHand::kStiffness;
  CutPath path;
  double t = 0;
  for (const Vec3d& p : {Vec3d(-1, -1, 0.2), Vec3d(-1, -1, -0.7), Vec3d(1, -1, -0.7), Vec3d(1, 1, -0.7)})
    path.poses.push_back({t++, {Eigen::Quaterniond::Identity(), p}});
  path.cuts = {1, 1, 1};

  const auto object = block({4, 4, 2}, voxel);
  SweepCutter sweep(object->phi0());
  RevolvedProfile ball;
  ball.arcTo({0, 0.5}, {0, 1});
  const RevolvedShape shape(ball);
  for (std::size_t n = 0; n + 1 < path.poses.size(); ++n)
    sweep.advance(SweptTool(shape, path.poses[n].T_object_tool, path.poses[n + 1].T_object_tool));
  const double planned =
      internal::sumOf(internal::removedVolumes(object->phi0(), sweep.cutField(), internal::materialsOf(*object)));

  State state;
  state.objects.emplace_back(object, 8192);
  ForceHand::Options options;
  options.force = force;
  ForceHand hand(path, model.settings.coupling, options);
  StepOutput out;
  DeviceSample sample;
  state.place(poseAt(path, 0));
  double removed = 0;
  for (int n = 0; n < 120'000 && hand.next(out, sample); ++n) {
    step(model, state, sample, out);
    removed += out.removed_mm3;
  }
  EXPECT_FALSE(hand.gaveUp()) << force;
  EXPECT_EQ(hand.progress(), 1) << force;
  return removed / planned;
}

TEST(VirtualHand, APathWithCornersIsCutAsPlannedHoweverHardItIsPushed) {
  for (const double voxel : {0.1, 0.2}) {
    for (const double force : {0.2, 0.5}) EXPECT_NEAR(shareOfThePlan(force, voxel), 1, 0.05) << force;
    // At this speed in such a soft tissue, a film remains on the walls.
    for (const double force : {1.5, 3.0}) EXPECT_NEAR(shareOfThePlan(force, voxel), 1, 0.1) << force;
  }
}

// A bur of the rack in a block of one tissue, a path, a pushing hand: the results.
struct Pushed {
  bool gave_up = false;
  double farthest_off = 0;  // mm, of the tip from the straight path
  double stalled_s = 0, fell_to = 1, seconds = 0;
  Rigid3 end;
};
Pushed pushAlong(const CutPath& path, const char* tool_id, double force, const Rigid3& attitude,
                 double of_its_torque = 1) {
  const auto file = findToolFile(tool_id, defaultToolFolders());
  EXPECT_TRUE(file);
  Model model;
  model.tools = {makeToolModel(*readTool(*file))};
  model.tools[0].drive.stall_load *= of_its_torque;
  model.tissues = oneTissue(200, 0.3, 1000);
  model.settings.coupling.stiffness = ForceHand::kStiffness;
  State state;
  state.objects.emplace_back(block({5, 5, 4}, 0.1, attitude), 8192);
  ForceHand::Options options;
  options.force = force;
  options.free_speed = model.tools[0].drive.speed;
  ForceHand hand(path, model.settings.coupling, options);
  state.place(poseAt(path, 0));

  Pushed out;
  StepOutput tick;
  DeviceSample sample;
  bool has_come_up = false;
  const Vec3d from = path.poses.front().T_object_tool.translation;
  const Vec3d along = (path.poses.back().T_object_tool.translation - from).normalized();
  for (int n = 0; n < 120'000 && hand.next(tick, sample); ++n) {
    step(model, state, sample, tick);
    out.seconds += kTick;
    const Vec3d way = tick.T_world_tool.translation - from;
    out.farthest_off = std::max(out.farthest_off, (way - along.dot(way) * along).norm());
    const double speed = tick.speed / model.tools[0].drive.speed;
    has_come_up = has_come_up || speed > 0.5;
    if (!has_come_up) continue;
    out.fell_to = std::min(out.fell_to, speed);
    if (speed < 0.02) out.stalled_s += kTick;
  }
  out.gave_up = hand.gaveUp();
  out.end = tick.T_world_tool;
  return out;
}

// A slope pushes a bur aside as it comes down, and drag makes it walk.
TEST(VirtualHand, AHandHoldsATurbineOnItsLineOnASlope) {
  for (const double degrees : {20.0, 45.0, 60.0})
    for (const double force : {0.5, 1.0, 2.0}) {
      const Rigid3 slope = turned(degrees * std::numbers::pi / 180, {1, 0.3, 0});
      const Pushed pushed = pushAlong(straight({0, 0, 2}, {0, 0, -1}, 1), "round-014", force, slope);
      EXPECT_FALSE(pushed.gave_up) << degrees << " " << force;
      EXPECT_LT(pushed.farthest_off, 0.15) << degrees << " " << force;
    }
}

TEST(VirtualHand, AHandThatStallsItsTurbineLetsGoAndComesToTheEnd) {
  const Pushed pushed = pushAlong(straight({-3.5, 0, -1.5}, {0, 0, -1.5}, 1), "856-016", 6, {});
  EXPECT_FALSE(pushed.gave_up);
  EXPECT_LT(pushed.fell_to, 0.1);
  EXPECT_LT(pushed.stalled_s, 1);
  EXPECT_NEAR(pushed.end.translation[0], 0, 0.05);
}

TEST(VirtualHand, AHandGivesUpWhenItsDriveStallsAgainAndAgain) {
  const Pushed pushed = pushAlong(straight({0, 0, 0.5}, {0, 0, -2}, 1), "round-014", 8, {}, 1e-4);
  EXPECT_TRUE(pushed.gave_up);
  EXPECT_LT(pushed.fell_to, 0.1);
  EXPECT_LT(pushed.seconds, 60);
}

// The drive is off on the way back, while the tool still overlaps the wall of its slot.
TEST(VirtualHand, AToolWhoseDriveIsOffIsDrawnOutOfItsSlot) {
  CutPath path = straight({-3.5, 0, -1.5}, {-1, 0, -1.5}, 1);
  path.poses.push_back({2, {Eigen::Quaterniond::Identity(), {-1, 0, 1}}});
  path.cuts = {1, 0};
  for (const double push : {0.5, 3.0}) {
    const Pushed pushed = pushAlong(path, "837-012", push, {});
    EXPECT_FALSE(pushed.gave_up) << push;
    EXPECT_NEAR(pushed.end.translation[2], 1, 0.02) << push;
  }
}

// A shallow pocket of 1.5 x 0.7 mm by a bur of the rack.
struct Pocket {
  double force = 0;          // N on the tool, mean during contact
  double share = 0;          // share of the planned volume that was removed
  double removed = 0;        // total, relative to the planned volume
  double end = 0, left = 0;  // mm from the end of the path; of the path
  double least_speed = 1;    // of the drive, after it has reached the speed of its load
  double strongest = 0;      // N
  bool gave_up = false;
};
// @param energy  to cut 1 mm^3, N mm.
Pocket pocket(const char* tool_id, double energy, double depth, double push, double voxel) {
  Pocket out;
  const auto file = findToolFile(tool_id, defaultToolFolders());
  const auto tool = file ? readTool(*file) : Expected<Tool>(fail(file.error()));
  EXPECT_TRUE(tool) << tool_id;
  if (!tool) return out;
  Model model;
  model.tools = {makeToolModel(*tool)};
  model.tissues = oneTissue(200, 0.3, energy);
  model.settings.coupling.stiffness = ForceHand::kStiffness;
  CutPath path;
  for (const Vec3d& p :
       {Vec3d(-0.75, -0.35, 0.3), Vec3d(-0.75, -0.35, -depth), Vec3d(0.75, -0.35, -depth), Vec3d(0.75, 0, -depth),
        Vec3d(-0.75, 0, -depth), Vec3d(-0.75, 0.35, -depth), Vec3d(0.75, 0.35, -depth)})
    path.poses.push_back({static_cast<double>(path.poses.size()), {Eigen::Quaterniond::Identity(), p}});
  path.cuts.assign(path.poses.size() - 1, 1);

  const auto object = block({4, 3, 2}, voxel);
  SweepCutter sweep(object->phi0());
  for (std::size_t n = 0; n + 1 < path.poses.size(); ++n)
    sweep.advance(SweptTool(*tool->cut, path.poses[n].T_object_tool, path.poses[n + 1].T_object_tool));
  const BrickField plan = sweep.cutField();
  State state;
  state.objects.emplace_back(object, 8192);
  ForceHand hand(path, model.settings.coupling, {.force = push, .free_speed = model.tools[0].drive.speed});
  StepOutput tick;
  DeviceSample sample;
  state.place(poseAt(path, 0));
  int touching = 0;
  for (int n = 0; n < 120'000 && hand.next(tick, sample); ++n) {
    step(model, state, sample, tick);
    out.removed += tick.removed_mm3;
    const double force = tick.contact.force.norm();
    out.strongest = std::max(out.strongest, force);
    if (tick.touching == 0) continue;
    ++touching;
    out.force += force;
    out.least_speed = std::min(out.least_speed, tick.speed / model.tools[0].drive.speed);
  }
  out.force /= std::max(touching, 1);
  const double planned =
      internal::sumOf(internal::removedVolumes(object->phi0(), plan, internal::materialsOf(*object)));
  out.share = internal::commonVolume(object->phi0(), plan, state.objects[0].bricks().changedField()) / planned;
  out.removed /= planned;
  out.end = (tick.T_world_tool.translation - path.poses.back().T_object_tool.translation).norm();
  out.left = hand.left();
  out.gave_up = hand.gaveUp();
  return out;
}

TEST(VirtualHand, TheForceAskedForIsAppliedOnShortStrokesAndMoreOfItRemovesNoLess) {
  test::Slice slice(5);
  constexpr double kDentin = 1000, kEnamel = 4200;
  for (const char* tool : {"us-330", "801-014", "801-018", "856-016"})
    for (const double energy : {kDentin, kEnamel})
      for (const double depth : {0.1, 0.2, 0.4}) {
        if (!slice.has()) continue;
        double most = 0;
        for (const double push : {0.3, 1.0, 2.0, 4.0, 8.0}) {
          const Pocket p = pocket(tool, energy, depth, push, 0.1);
          const std::string where = fmt::format(
              "{} {} mm deep, {} N, {} N mm/mm3: {:.3f} N, {:.3f} of the plan, {:.3f} in all, drive at {:.2f}", tool,
              depth, push, energy, p.force, p.share, p.removed, p.least_speed);
          EXPECT_FALSE(p.gave_up) << where;
          EXPECT_LE(p.end, 0.02) << where;
          EXPECT_NEAR(p.left, 0, 1e-9) << where;
          if (p.least_speed < 0.1) continue;  // overloaded: the hand lets go, or is about to
          EXPECT_NEAR(p.force / push, 1, 0.1) << where;
          EXPECT_GT(p.removed, most - 0.02) << where;
          EXPECT_GT(p.share, 0.95) << where;
          most = std::max(most, p.removed);
        }
      }
}

TEST(VirtualHand, ATurnOnTheSpotTakesItsTime) {
  CutPath path = straight({0, 0, 3}, {0, 0, 3}, 1);
  path.poses[1].T_object_tool.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vec3d::UnitX()));
  ForceHand hand(path, CouplingSettings{}, ForceHand::Options{});
  StepOutput out;
  out.T_world_tool = poseAt(path, 0);
  DeviceSample sample;
  int ticks = 0;
  double last = 0, fastest = 0;
  for (; ticks < 5000 && hand.next(out, sample); ++ticks) {
    const double angle = sample.T_world_device.rotation.angularDistance(Eigen::Quaterniond::Identity());
    fastest = std::max(fastest, (angle - last) / kTick);
    last = angle;
    out.T_world_tool = sample.T_world_device;
  }
  EXPECT_NEAR(last, 0.5, 1e-6);
  EXPECT_NEAR(fastest, 1, 1e-6);
  EXPECT_NEAR(ticks * kTick, 0.5, 0.01);
}

// A hand that presses a device on a rigid block.
double worstEnergy(Rendering rendering, double stiffness, const DeviceHand::Options& options) {
  Model model;
  model.tools = {practiceBall(0.5, 0)};
  model.tissues = oneTissue(200, 0, 1000);
  model.settings.rendering = rendering;
  model.settings.coupling.stiffness = stiffness;
  model.settings.ramp_s = 0;
  return scenes::press(model, block({4, 4, 2}, 0.1), options).energy;
}

TEST(VirtualHand, TheCouplingGivesNoEnergyAwayWhereDirectRenderingDoes) {
  for (const double hand_stiffness : {0.1, 0.3, 1.0}) {
    DeviceHand::Options options;
    options.hand_stiffness = hand_stiffness;
    options.hand_damping = 0.001 + 0.002 * hand_stiffness;
    EXPECT_LT(worstEnergy(Rendering::kCoupled, 0.5, options), 1e-3) << hand_stiffness;
    EXPECT_LT(worstEnergy(Rendering::kCoupled, 1.0, options), 1e-3) << hand_stiffness;
    EXPECT_GT(worstEnergy(Rendering::kDirect, 1.0, options), 0.1) << hand_stiffness;
  }
}

}  // namespace
}  // namespace kerf::virtual_hand_test
