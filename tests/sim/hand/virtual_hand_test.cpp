#include "sim/hand/virtual_hand.h"

#include <gtest/gtest.h>

#include "geometry/tool/sweep.h"
#include "sim/run/removed_volumes.h"
#include "sim/run/sweep_cutter.h"
#include "tests/sim/block_scene.h"
#include "ui/bench/scenes/press.h"

namespace kerf {
namespace {

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
// A ball pressed with constant force into a block, its surface moving at 840 mm/s; from when its equator is in.
Plunge plunge(double force, double voxel) {
  Model model;
  model.tools = {practiceBall(0.5, 840)};
  model.tissues = oneTissue(200, 0.5, 1000);
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
    // Counted where the surface crosses the grid, so windows of a slow cut are a little rough.
    EXPECT_LT(p.spread, 0.035) << force;
    // N is 3/2 of the force on a hemisphere whose pressure follows its overlap.
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

// What a ball of 1 mm removes along a path with two corners, over what it sweeps.
double shareOfThePlan(double force, double voxel) {
  Model model;
  model.tools = {practiceBall(0.5, 8400)};
  model.tissues = oneTissue(200, 0.3, 1000);
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
    // So fast in what is this soft that a film is left on the walls.
    for (const double force : {1.5, 3.0}) EXPECT_NEAR(shareOfThePlan(force, voxel), 1, 0.1) << force;
  }
}

// A hand that presses a device on a block which does not give way.
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
}  // namespace kerf
