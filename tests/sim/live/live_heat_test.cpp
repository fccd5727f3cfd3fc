#include "sim/live/live_heat.h"

#include <gtest/gtest.h>

#include "sim/monitor/monitor.h"
#include "sim/session/session.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::live_heat_test {
namespace {

using test::block;
using test::oneTissue;
using test::sampleAt;

constexpr double kVoxel = 0.1;

Rigid3 at(double x, double z) { return {Eigen::Quaterniond::Identity(), Vec3d(x, 0, z)}; }

// A block with its top at z = 0, a small ball and a larger one.
struct Scene {
  LoadedObjects objects{block({3, 3, 2}, kVoxel)};
  Model model;
  std::vector<ToolSamples> samples;

  Scene() {
    for (const double radius : {0.5, 0.8}) model.tools.push_back(practiceBall(radius, 2000));
    for (const ToolModel& tool : model.tools) samples.emplace_back(tool.cut, kToolSamples);
    model.tissues = oneTissue(60, 0.1, 1e3);
  }
};

// Dry, with tool n, from above into the block.
template <class After>
void drill(Session& session, int ticks, const After& after) {
  StepOutput output;
  for (int n = 0; n < ticks; ++n) {
    DeviceSample sample = sampleAt(at(0, 0.2 - 0.001 * n), 1);
    sample.irrigation = 0;
    session.tick(sample, output);
    after(sample, output);
  }
}

TEST(LiveHeat, IsThatOfACutAlongAPath) {
  const Scene scene;
  const HeatSource source{.share = 0.6};
  auto monitor = Monitor::make(scene.objects, scene.model.tools[0], source);
  ASSERT_TRUE(monitor) << monitor.error().message();
  LiveHeat heat(scene.model.tools);
  heat.add(0, scene.samples[0], source);

  Session session(scene.model, scene.objects, at(0, 1));
  double hottest = 0;
  drill(session, 600, [&](const DeviceSample& sample, const StepOutput& output) {
    const AllocationGuard guard;
    heat.tick(0, sample, output, session.state().objects);
    monitor->tick(sample, output, session.state().objects);
    ASSERT_EQ(heat.report().surface, monitor->temperature());
    hottest = std::max(hottest, heat.report().surface);
  });
  EXPECT_TRUE(heat.report().is_known);
  EXPECT_GT(hottest, kBodyCelsius + 5) << "or the test says nothing";
}

TEST(LiveHeat, IsUnknownOfAToolThatWasNotMade) {
  const Scene scene;
  LiveHeat heat(scene.model.tools);
  heat.add(7, scene.samples[0], {});  // no such tool
  heat.add(1, scene.samples[1], {});
  Session session(scene.model, scene.objects, at(0, 1));
  drill(session, 300, [&](const DeviceSample& sample, const StepOutput& output) {
    heat.tick(0, sample, output, session.state().objects);
  });
  EXPECT_FALSE(heat.report().is_known);
  EXPECT_EQ(heat.report().surface, kBodyCelsius);
}

TEST(LiveHeat, WhatOneToolWarmedIsWarmWhenAnotherIsTaken) {
  const Scene scene;
  LiveHeat heat(scene.model.tools);
  for (const std::size_t n : {0u, 1u}) heat.add(n, scene.samples[n], {.share = 0.6});
  Session session(scene.model, scene.objects, at(0, 1));
  drill(session, 600, [&](const DeviceSample& sample, const StepOutput& output) {
    heat.tick(0, sample, output, session.state().objects);
  });
  const double before = heat.report().surface;
  ASSERT_GT(before, kBodyCelsius + 5);

  StepOutput away;
  away.T_world_tool = at(0, 5);
  heat.tick(1, sampleAt(at(0, 5), 0), away, session.state().objects);
  EXPECT_TRUE(heat.report().is_known);
  EXPECT_LT(heat.report().surface, before);
  EXPECT_GT(heat.report().surface, kBodyCelsius + 2) << "it cools as it was warmed";
}

}  // namespace
}  // namespace kerf::live_heat_test
