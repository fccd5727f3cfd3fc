// Friction of a tool at rest: it holds up to its limit, does not creep, and creates no energy.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "bench/scenes/sink.h"
#include "geometry/tool/tool_file.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/places.h"

namespace kerf::grip_test {
namespace {

constexpr double kFriction = 0.3;

ToolModel toolOfRack(const std::string& id) {
  const auto tool = readTool(std::filesystem::path(kSourceFolder) / "assets/tools" / (id + ".toml"));
  EXPECT_TRUE(tool) << tool.error().message();
  return makeToolModel(*tool);
}

struct Push {
  double load = 1;       // N
  double part = 0.7;     // share of the side force held by friction
  double trembling = 0;  // of the side force, to and fro
  double voxel = 0.1;
  double seconds = 2;
};

// Sideways motion of a tool at rest on a block in the last second of a push, mm.
double creep(const ToolModel& tool, const Push& push) {
  Model model;
  model.tools = {tool};
  model.tissues = test::oneTissue(200, kFriction, 1000);
  const Rigid3 frame = scenes::turned(0.4, {1, 0.3, 0.2}, {0.013, 0.02, 0});
  State state;
  state.objects.emplace_back(test::block({8, 8, 3}, push.voxel, frame), 16);
  const Vec3d tip = scenes::foremost(tool, -Vec3d::UnitZ());
  Rigid3 at = frame * Rigid3{Eigen::Quaterniond::Identity(), Vec3d(0.02, -0.03, 0.02) - tip};
  const Eigen::Quaterniond held = at.rotation;
  const Vec3d aside(0.6, 0.8, 0);
  state.place(at);

  const double angle = std::atan(push.part * kFriction * tool.drive.drag_factor);
  StepOutput out;
  Vec3d before = at.translation;
  const AllocationGuard guard;
  const int ticks = static_cast<int>(push.seconds / kTick);
  for (int n = 0; n < ticks; ++n) {
    const double t = n * kTick, down = push.load * std::cos(angle) * std::min(1.0, t / 0.2);
    const double shaken = 1 - push.trembling + push.trembling * std::sin(2 * std::numbers::pi * 17 * t);
    const double side = push.load * std::sin(angle) * std::clamp((t - 0.3) / 0.2, 0.0, 1.0) * shaken;
    const Vec3d pull = frame.rotation * Vec3d(side * aside - down * Vec3d::UnitZ());
    step(model, state, test::sampleAt({held, at.translation + pull / model.settings.coupling.stiffness}, 0), out);
    at = out.T_world_tool;
    if (n == ticks - 1001) before = at.translation;
  }
  return aside.dot(frame.rotation.conjugate() * (at.translation - before));
}

TEST(Grip, AToolAtRestDoesNotCreepOverToolsLoadsAndVoxels) {
  for (const char* id : {"round-014", "837-012", "847-012"})
    for (const double load : {0.3, 2.0, 7.5})
      for (const double voxel : {0.05, 0.1, 0.15})
        EXPECT_NEAR(creep(toolOfRack(id), {.load = load, .voxel = voxel}), 0, 2e-4)
            << fmt::format("{}, {} N, voxels {}", id, load, voxel);
}

TEST(Grip, TremblingDoesNotWalkIt) {
  for (const char* id : {"round-014", "837-012"})
    EXPECT_NEAR(creep(toolOfRack(id), {.load = 5, .trembling = 0.4}), 0, 5e-4) << id;
}

TEST(Grip, BeyondFrictionItSlides) { EXPECT_GT(creep(toolOfRack("round-014"), {.load = 2, .part = 1.3}), 0.1); }

}  // namespace
}  // namespace kerf::grip_test
