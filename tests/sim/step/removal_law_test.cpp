// A hand pushes a ball into a block and along it: the load follows from the hand's force, and determines the removal.
#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/field/marching_cubes.h"
#include "tests/sim/block_scene.h"

namespace kerf::removal_law_test {
namespace {

struct Groove {
  double ledger = 0, mesh = 0, law = 0;  // mm^3 removed: by the ledger, by the mesh, the integral of mu N v_s / u_s
};

double meshVolume(const BrickField& field) { return signedVolume(marchingCubes(field)); }

// A ball of 1.6 mm on the coupling. The device moves `push` mm into the block in 0.3 s, then 2 mm along it at 5 mm/s.
Groove grooveOf(double voxel, double push) {
  constexpr double kFriction = 0.5, kSpeed = 840, kEnergy = 1000;
  constexpr int kPress = 300, kSlide = 400;  // ticks
  Model model;
  model.tools = {practiceBall(0.8, kSpeed)};
  model.tissues = test::oneTissue(200, kFriction, kEnergy);
  const Rigid3 frame = scenes::askew();
  State state;
  state.objects.emplace_back(test::block({5, 3, 2}, voxel, frame), 8192);
  state.speed = kSpeed;

  const auto deviceAt = [&](double x, double z) {
    return test::sampleAt(frame * Rigid3{Eigen::Quaterniond::Identity(), {x, 0.01, z}});
  };
  state.place(deviceAt(-1, 0.1).T_world_device);
  const double before = meshVolume(scenes::currentField(state.objects[0]));

  Groove out;
  StepOutput tick;
  for (int n = 0; n < kPress + kSlide; ++n) {
    const double pressed = std::min(1.0, static_cast<double>(n) / kPress);
    const double slid = std::max(0.0, static_cast<double>(n - kPress) / kSlide);
    scenes::reserveForTicks(state.objects[0]);
    step(model, state, deviceAt(-1 + 2 * slid, 0.1 - (push + 0.1) * pressed), tick);
    EXPECT_EQ(tick.status & ~kStepForceClamped, kStepOk) << "voxels of " << voxel << " mm, tick " << n;
    out.ledger += tick.removed_mm3;
    out.law += kFriction * tick.normal_load * kSpeed / kEnergy * kTick;
  }
  out.mesh = before - meshVolume(scenes::currentField(state.objects[0]));
  return out;
}

// Measured: 0.9 % off the law at most, as the factor on areas follows the start of a cut within 0.15 s. Without that
// factor: 2.9 %. Ledger and mesh measure the same cells, and differ by 0.1 %.
void expectLaw(const Groove& groove, double voxel, double push) {
  const testing::Message scene = testing::Message() << "voxels of " << voxel << " mm, pushed by " << push << " mm";
  ASSERT_GT(groove.law, 0.05) << scene;
  EXPECT_NEAR(groove.ledger / groove.law, 1, 0.01) << scene;
  EXPECT_NEAR(groove.mesh / groove.law, 1, 0.01) << scene;
  EXPECT_NEAR(groove.mesh / groove.ledger, 1, 0.004) << scene;
}

// Measured: 0.9 %, from the direction of the load at the lip of the groove, which is 0.13 mm deep.
TEST(RemovalLaw, APushedBallRemovesTheSameWhateverTheVoxel) {
  double least = 1e9, most = 0;
  for (const double voxel : {0.1, 0.05, 0.025}) {
    const Groove groove = grooveOf(voxel, 1);
    expectLaw(groove, voxel, 1);
    least = std::min(least, groove.mesh);
    most = std::max(most, groove.mesh);
  }
  EXPECT_LT(most / least - 1, 0.01);
}

TEST(RemovalLaw, HoldsWhateverTheForce) {
  for (const double voxel : {0.1, 0.05})
    for (const double push : {0.5, 2.0, 4.0}) expectLaw(grooveOf(voxel, push), voxel, push);
}

// A ball pushed straight into a block, from 0.3 to 0.7 mm deep. Pressure is proportional to the cosine of the slope, so
// by its shape the load is 1.5 (1 - c^2) / (1 - c^3) times the hand's force, c the cosine at the rim.
struct Plunge {
  double load = 0, of_shape = 0;  // N s: the load, and its prediction from the hand's force and the shape
};
Plunge plungeOf(double voxel, double force) {
  constexpr double kRadius = 0.8;
  Model model;
  model.tools = {practiceBall(kRadius, 840)};
  model.tissues = test::oneTissue(200, 0.5, 1000);
  const Rigid3 frame = scenes::askew();
  State state;
  state.objects.emplace_back(test::block({4, 4, 2}, voxel, frame), 8192);
  state.speed = model.tools[0].drive.speed;

  Plunge out;
  StepOutput tick;
  Rigid3 tool = frame * Rigid3{Eigen::Quaterniond::Identity(), {0.01, 0.02, 0}};
  state.place(tool);
  const Vec3d normal = frame.rotation * Vec3d::UnitZ();
  for (int n = 0; n < 5000; ++n) {
    const double depth = -(frame.inverse() * tool).translation[2];
    if (depth > 0.7) return out;
    scenes::reserveForTicks(state.objects[0]);
    const Vec3d hand = tool.translation - force / model.settings.coupling.stiffness * normal;
    step(model, state, test::sampleAt({tool.rotation, hand}), tick);
    tool = tick.T_world_tool;
    if (depth < 0.3) continue;
    const double c = 1 - depth / kRadius;
    out.load += tick.normal_load * kTick;
    out.of_shape += tick.force.force.dot(normal) * 1.5 * (1 - c * c) / (1 - c * c * c) * kTick;
  }
  ADD_FAILURE() << "the ball did not go in";
  return out;
}

// Measured: 1.5 and 1.9 % short at 0.05 mm (3.1 and 3.5 at 0.1 mm), as the tissue's normals tilt at the lip. With the
// tool balanced by the overlap after an evaluation instead of its mean, it is 5.2 and 5.6 %.
TEST(RemovalLaw, TheHandsForceReachesTheTissue) {
  for (const double force : {0.5, 2.0}) {
    const Plunge plunge = plungeOf(0.05, force);
    EXPECT_NEAR(plunge.load / plunge.of_shape, 1, 0.03) << force << " N";
  }
}

}  // namespace
}  // namespace kerf::removal_law_test
