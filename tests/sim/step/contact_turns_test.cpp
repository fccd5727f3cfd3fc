// Contacts too large for a tick, processed in turns: the same force and removal as all at once, at a part of the work.
#include "sim/step/contact_turns.h"

#include <gtest/gtest.h>

#include "sim/session/state_bytes.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::contact_turns_test {
namespace {

using test::sampleAt;

// A ball of 6 mm, 2 mm deep in bone, its cavity cut beforehand.
struct SunkBall {
  static constexpr double kDeep = 2;
  static constexpr double kFriction = 0.5, kSpeed = 840, kEnergy = 1000;

  LoadedObjects loaded{test::block({8, 8, 4}, 0.1)};
  Model model;
  State state;
  StepOutput out;
  int ticks = 0;

  explicit SunkBall(bool takes_turns) {
    model.tools = {practiceBall(3, kSpeed)};
    model.tissues = test::oneTissue(200, kFriction, kEnergy);
    model.settings.rendering = Rendering::kRigid;
    model.settings.takes_turns = takes_turns;
    state.objects.reserve(kMostObjects);
    state.objects.emplace_back(loaded[0], 8192).id = state.next_id++;

    model.settings.geometry_only = true;
    state.place(at(0.1));
    for (int n = 0; n <= 200; ++n) step(model, state, sampleAt(at(0.1 - n * (kDeep + 0.1) / 200), 0), out);
    model.settings.geometry_only = false;
  }

  static Rigid3 at(double z) { return {Eigen::Quaterniond::Identity(), {0, 0, z}}; }
  /// One more tick of a feed of 0.1 mm/s.
  void tick() {
    step(model, state, sampleAt(at(-kDeep - 1e-4 * ticks)), out);
    ++ticks;
  }
  const ContactTurns& turns() const { return state.turns[0]; }
};

TEST(ContactTurns, ForceAndRemovalAreThoseOfAllAtOnceAtAPartOfTheWork) {
  SunkBall all(false), turns(true);
  double force[2] = {}, removed[2] = {}, load[2] = {}, power[2] = {}, most_jump = 0, most_apart = 0;
  int cut[2] = {};
  Vec3d last = Vec3d::Zero();
  constexpr int kSettled = 200, kTicks = 600;
  for (int n = 0; n < kTicks; ++n) {
    int which = 0;
    for (SunkBall* ball : {&all, &turns}) {
      ball->tick();
      ASSERT_EQ(ball->out.status, kStepOk);
      if (n >= kSettled) {
        force[which] += ball->out.contact.force[2];
        removed[which] += ball->out.removed_mm3;
        load[which] += ball->out.cutting_load;
        power[which] += ball->out.power;
        cut[which] += ball->out.bricks_cut;
      }
      ++which;
    }
    if (n > kSettled) most_jump = std::max(most_jump, (turns.out.contact.force - last).norm());
    if (n > kSettled) most_apart = std::max(most_apart, (turns.out.contact.force - all.out.contact.force).norm());
    last = turns.out.contact.force;
  }

  ASSERT_FALSE(all.turns().isActive());
  ASSERT_TRUE(turns.turns().isActive());
  EXPECT_LT(2 * cut[1], cut[0]);
  EXPECT_NEAR(force[1] / force[0], 1, 0.005);
  EXPECT_NEAR(load[1] / load[0], 1, 0.005);
  EXPECT_NEAR(removed[1] / removed[0], 1, 0.002);
  EXPECT_LT(most_apart, 0.02 * force[0] / (kTicks - kSettled));
  EXPECT_LT(most_jump, 0.02);  // N a ms
  // The removal matches the work.
  EXPECT_NEAR(removed[1] / (power[1] * kTick / SunkBall::kEnergy), 1, 0.02);
}

TEST(ContactTurns, TheSameInputGivesTheSameBits) {
  const auto run = [] {
    SunkBall ball(true);
    for (int n = 0; n < 60; ++n) ball.tick();
    EXPECT_TRUE(ball.turns().isActive());
    return ball.state.hash();
  };
  EXPECT_EQ(run(), run());
}

TEST(ContactTurns, AnOrdinaryContactTakesNone) {
  const auto run = [](bool takes_turns) {
    Model model;
    model.tools = {practiceBall(0.5, 840)};
    model.tissues = test::oneTissue(200, 0.5, 1000);
    model.settings.takes_turns = takes_turns;
    State state;
    state.objects.emplace_back(test::block({4, 4, 2}, 0.05), 4096);
    state.place(SunkBall::at(0.1));
    StepOutput out;
    for (int n = 0; n < 500; ++n) step(model, state, sampleAt(SunkBall::at(0.1 - 0.002 * n)), out);
    EXPECT_GT(out.touching, 0);
    EXPECT_FALSE(state.turns[0].isActive());
    return state.hash();
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(ContactTurns, AStateFromBytesGoesOnBitForBit) {
  SunkBall ball(true);
  for (int n = 0; n < 45; ++n) ball.tick();
  ASSERT_TRUE(ball.turns().isActive());

  auto copy = unpackState(packState(ball.state, ball.loaded), ball.loaded, "test");
  ASSERT_TRUE(copy) << copy.error().message();
  EXPECT_EQ(copy->hash(), ball.state.hash());
  copy->objects[0].reserve(4096);
  for (int n = 0; n < 60; ++n) {
    StepOutput out;
    step(ball.model, *copy, sampleAt(SunkBall::at(-SunkBall::kDeep - 1e-4 * ball.ticks)), out);
    ball.tick();
    ASSERT_EQ(out.contact.force, ball.out.contact.force) << n;
  }
  EXPECT_EQ(copy->hash(), ball.state.hash());
}

TEST(ContactTurns, AToolThatComesOutIsNeverPulledBack) {
  SunkBall ball(true);
  for (int n = 0; n < 60; ++n) ball.tick();
  ASSERT_TRUE(ball.turns().isActive());
  const double from = ball.state.body.pose.translation[2];
  for (int n = 1; n <= 40; ++n) {  // 20 mm/s
    step(ball.model, ball.state, sampleAt(SunkBall::at(from + 0.02 * n)), ball.out);
    EXPECT_GE(ball.out.contact.force[2], -1e-9) << n;
    if (n > 2) EXPECT_EQ(ball.out.touching, 0) << n;
  }
  EXPECT_FALSE(ball.turns().isActive());
}

TEST(ContactTurns, ShellsAreRepairedWhenTheirTurnComes) {
  SunkBall ball(true);
  for (int n = 0; n < 60; ++n) ball.tick();
  CutObject& object = ball.state.objects[0];
  EXPECT_GT(object.dirtyCount(), 0u);
  ASSERT_TRUE(object.repair());
  EXPECT_EQ(object.bricks().shellDefects(), 0u);
}

TEST(ContactTurns, AnObjectThatIsMovedIsFeltWhereItIs) {
  SunkBall ball(true);
  for (int n = 0; n < 60; ++n) ball.tick();
  ASSERT_TRUE(ball.turns().isActive());
  ball.state.objects[0].moveTo({Eigen::Quaterniond::Identity(), {0, 0, -5}});
  ball.tick();
  EXPECT_EQ(ball.out.touching, 0);
  EXPECT_EQ(ball.out.contact.force, Vec3d::Zero());
}

TEST(ContactTurns, NothingIsAllocated) {
  SunkBall ball(true);
  for (int n = 0; n < 30; ++n) ball.tick();
  {
    const AllocationGuard guard;  // ends the program if there is one
    for (int n = 0; n < 40; ++n) ball.tick();
  }
  EXPECT_TRUE(ball.turns().isActive());
}

}  // namespace
}  // namespace kerf::contact_turns_test
